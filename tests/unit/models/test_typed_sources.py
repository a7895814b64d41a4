"""What a user types as a source."""

import pytest

from grabbergui.models.sources import typed_uri


@pytest.mark.parametrize(
    ("typed", "uri"),
    [
        ("192.168.0.10", "gige:192.168.0.10"),
        ("movie.mp4", "file:movie.mp4"),
        (" ./run ", "file:./run"),
        ("file:movie.mp4", "file:movie.mp4"),
        ("twin:report.zip", "twin:report.zip"),
        ("rig:stereo.yaml", "rig:stereo.yaml"),
        ("RIG:run.mcap", "RIG:run.mcap"),
        ("gige:192.168.0.10", "gige:192.168.0.10"),
    ],
)
def test_a_kind_is_added_only_where_there_is_none(typed, uri):
    assert typed_uri(typed) == uri

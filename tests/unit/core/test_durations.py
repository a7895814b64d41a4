"""Durations in a unit that suits them: no message has ten digits of seconds."""

import pytest

from grabbergui.core.durations import duration_text


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (0.0351, "0.0351 s"),
        (299.6, "300 s"),
        (3600, "60 min"),
        (90_000, "25 h"),
        (30 * 86400, "30 days"),
        (1_795_875_123.25, "56.9 years"),
    ],
)
def test_a_duration_has_at_most_three_digits(seconds, text):
    assert duration_text(seconds) == text

"""The reference of the command line and of source URIs matches the program."""

from dataclasses import fields
from pathlib import Path

import pytest

from every_case import every_case
from grabbergui.cli.sources_help import sources_help
from grabbergui.core.errors import UsageError
from grabbergui.core.uri import SourceUri, option_rows, read_options
from grabbergui.driver.sim import power_on
from grabbergui.sources import SourceKind
from scripts import reference

ROOT = Path(__file__).parents[2]
KINDS = list(SourceKind)


@pytest.mark.parametrize("file", list(reference.files()), ids=lambda file: file.name)
def test_what_is_made_from_the_program_is_current(file):
    assert file.is_relative_to(ROOT)
    assert file.read_text("utf-8") == reference.files()[file], "run `python scripts/reference.py`"


@every_case("kind", KINDS, ids=str)
def test_a_uri_without_options_has_the_defaults(kind):
    assert read_options(kind.options, SourceUri(kind.value)) == kind.options()


@every_case("kind", KINDS, ids=str)
def test_an_unknown_option_is_named(kind):
    uri = SourceUri(kind.value, options={"colour_of_the_cable": "blue"})
    with pytest.raises(UsageError, match=r"no option colour_of_the_cable|sources have no options"):
        read_options(kind.options, uri)


def test_the_nearest_option_is_proposed():
    with pytest.raises(UsageError, match="did you mean packet_size"):
        read_options(SourceKind.GIGE.options, SourceUri.parse("gige:?packetsize=1500"))


@pytest.mark.parametrize(
    ("uri", "allowed"),
    [
        ("gige:?resend=perhaps", "write 0 or 1"),
        ("u3v:?transfers=0", "a number from 1 to 1024"),
        ("ros2:/a?qos=best", "write sensor_data or reliable"),
        ("file:a?speed=fast", "a number from 0.05 to 20"),
        ("file:a?speed=nan", "a number from 0.05 to 20"),
    ],
)
def test_a_bad_value_is_refused_with_the_allowed_ones(uri, allowed):
    parsed = SourceUri.parse(uri)
    with pytest.raises(UsageError, match=allowed):
        read_options(SourceKind(parsed.scheme).options, parsed)


def test_the_simulated_camera_has_a_register_for_every_option():
    assert set(power_on.REGISTERS) == {entry.name for entry in fields(SourceKind.SIM.options)}


def test_help_lists_every_option(capsys):
    text = sources_help()
    for kind in SourceKind:
        assert all(f"{row.name}={row.form}" in text for row in option_rows(kind.options))
        assert all(uri in text for uri, _ in kind.forms)

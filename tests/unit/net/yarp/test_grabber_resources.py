"""The files for yarpmanager and YARP programs fit what the server does."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

RESOURCES = Path(__file__).parents[4] / "resources" / "yarp"


def test_the_application_starts_what_it_connects() -> None:
    application = ElementTree.parse(RESOURCES / "applications" / "grabbergui.xml").getroot()
    commands = {
        module.findtext("name"): module.findtext("parameters") or "" for module in application.iter("module")
    }
    assert "--yarp /grabber" in commands["grabbergui"]
    for connection in application.iter("connection"):
        assert connection.findtext("from") == "/grabber"
        assert f"--name {connection.findtext('to')}" in commands["yarpview"]
        assert connection.findtext("protocol") == "fast_tcp"


def test_no_application_is_named_as_a_module_is() -> None:
    """yarpmanager keeps both in one list of names: it renames the second of a name and then loads neither."""
    applications, modules = (
        [ElementTree.parse(path).findtext("name") for path in (RESOURCES / kind).glob("*.xml")]
        for kind in ("applications", "modules")
    )
    names = applications + modules
    assert len(names) >= 2 and len(set(names)) == len(names)


def test_the_module_names_our_ports() -> None:
    module = ElementTree.parse(RESOURCES / "modules" / "grabbergui.xml").getroot()
    assert {port.text for port in module.iter("port")} == {"/grabber", "/grabber/rpc"}


def test_programs_open_the_shared_camera() -> None:
    for path in (RESOURCES / "contexts" / "grabbergui").glob("*.ini"):
        lines = [line.split(maxsplit=1) for line in path.read_text().splitlines() if line and line[0] != "#"]
        options = dict(lines)
        assert options["device"] == "frameGrabber_nwc_yarp"
        assert options["remote"] == "/grabber"

"""The desktop's entry and its types of files, by the desktop's own tools where they are installed."""

import configparser
import shutil
import subprocess
import xml.etree.ElementTree as ET

import pytest

from grabbergui.core.environment import RESOURCES
from grabbergui.core.errors import UsageError
from grabbergui.setup.desktop_entry import DesktopEntry, exec_value
from patience import PROGRAM


def tool(name):
    return pytest.mark.skipif(shutil.which(name) is None, reason=f"{name} is not installed")


def run(*command):
    return subprocess.run(command, capture_output=True, text=True, timeout=PROGRAM)


@pytest.fixture
def entry(tmp_path):
    entry = DesktopEntry(tmp_path / "share")
    entry.install(["/opt/cameras & co/bin/grabbergui"])
    return entry


def test_installing_and_removing_leaves_nothing(entry):
    assert all(file.is_file() for file in entry.files())
    assert entry.remove() == entry.files()
    assert not [file for file in entry.data.rglob("*") if file.is_file()]
    assert entry.remove() == []


def test_the_entry_starts_this_program(entry):
    parser = configparser.RawConfigParser()
    parser.optionxform = str
    parser.read(entry.data / "applications" / "grabbergui.desktop", "utf-8")
    section = parser["Desktop Entry"]
    assert section["Exec"] == '"/opt/cameras & co/bin/grabbergui" %u'
    assert section["TryExec"] == "/opt/cameras & co/bin/grabbergui"


@pytest.mark.parametrize(
    ("program", "value"),
    [
        (["/usr/bin/grabbergui"], "/usr/bin/grabbergui"),
        (["/a b/grabbergui"], '"/a b/grabbergui"'),
        (["/100%/grabbergui"], "/100%%/grabbergui"),
        (["/a$b/grabbergui"], '"/a\\\\$b/grabbergui"'),
        (["/a\\b/grabbergui"], '"/a\\\\\\\\b/grabbergui"'),
        (["/usr/bin/python3", "-m", "grabbergui"], "/usr/bin/python3 -m grabbergui"),
    ],
)
def test_a_path_is_quoted_as_the_specification_says(program, value):
    assert exec_value(program) == value


def test_a_path_that_no_entry_can_have_is_refused():
    with pytest.raises(UsageError, match="another folder"):
        exec_value(["/a=b/grabbergui"])


@tool("desktop-file-validate")
def test_the_entry_is_valid(entry):
    done = run("desktop-file-validate", str(entry.data / "applications" / "grabbergui.desktop"))
    assert (done.returncode, done.stdout) == (0, "")


def test_the_entry_opens_the_types_that_are_declared():
    namespace = {"": "http://www.freedesktop.org/standards/shared-mime-info"}
    root = ET.parse(RESOURCES / "desktop" / "grabbergui-mime.xml").getroot()
    declared = {each.attrib["type"] for each in root.findall("mime-type", namespace)}
    text = (RESOURCES / "desktop" / "grabbergui.desktop").read_text("utf-8")
    line = next(line for line in text.splitlines() if line.startswith("MimeType="))
    assert set(line.removeprefix("MimeType=").strip(";").split(";")) == declared

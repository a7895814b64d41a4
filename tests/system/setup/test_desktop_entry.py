"""The desktop's entry and its types of files, by the desktop's own tools where they are installed."""

import configparser
import shutil
import subprocess
import sys
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


@tool("appstreamcli")
def test_the_description_has_no_error():
    done = run("appstreamcli", "validate", "--no-net", str(RESOURCES / "desktop/grabbergui.metainfo.xml"))
    assert [line for line in done.stdout.splitlines() if line.startswith(("E:", "W:"))] == []
    assert done.returncode == 0


@tool("update-mime-database")
def test_recordings_and_settings_are_recognised(entry, tmp_path, monkeypatch):
    shutil.copy("/usr/share/mime/packages/freedesktop.org.xml", entry.data / "mime" / "packages")
    entry.refresh()
    monkeypatch.setenv("XDG_DATA_HOME", str(entry.data))
    monkeypatch.setenv("XDG_DATA_DIRS", str(tmp_path))
    settings = tmp_path / "settings.yaml"
    saved = run(sys.executable, "-m", "grabbergui", "save", "sim:", str(settings))
    assert saved.returncode == 0
    magic = (entry.data / "mime" / "magic").read_bytes()
    assert b"application/x-mcap" in magic and b"application/x-grabbergui-settings+yaml" in magic
    globs = (entry.data / "mime" / "globs2").read_text("utf-8")
    assert "application/x-mcap:*.mcap" in globs
    # What the magic looks for is what the program writes.
    text = settings.read_text("utf-8")
    assert text.startswith("device: ") and "\nfeatures:\n" in text[:264]


def test_the_entry_opens_the_types_that_are_declared():
    namespace = {"": "http://www.freedesktop.org/standards/shared-mime-info"}
    root = ET.parse(RESOURCES / "desktop" / "grabbergui-mime.xml").getroot()
    declared = {each.attrib["type"] for each in root.findall("mime-type", namespace)}
    text = (RESOURCES / "desktop" / "grabbergui.desktop").read_text("utf-8")
    line = next(line for line in text.splitlines() if line.startswith("MimeType="))
    assert set(line.removeprefix("MimeType=").strip(";").split(";")) == declared

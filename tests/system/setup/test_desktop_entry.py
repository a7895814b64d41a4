"""The desktop's entry and its types of files, by the desktop's own tools where they are installed."""

import shutil
import subprocess
import sys

import pytest

from grabbergui.core.environment import RESOURCES
from grabbergui.setup.desktop_entry import DesktopEntry
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

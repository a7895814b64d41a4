"""Configuration files as YARP writes and finds them."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grabbergui.config import ini
from grabbergui.core.errors import UsageError

CAMERA_INI = """
// the camera of the head
device   AravisCamera
index 0
pixelFormat "Mono 8"
introspection = false
fake
# a comment
[YARP_CAMERA   right]
period\t0.033
name /right image
"""


def test_keys_and_sections():
    sections = ini.parse(CAMERA_INI)

    assert sections[""].values == {
        "device": "AravisCamera", "index": "0", "pixelFormat": "Mono 8", "introspection": "false", "fake": "",
    }  # fmt: skip
    assert sections["YARP_CAMERA right"].values == {"period": "0.033", "name": "/right image"}


@pytest.mark.parametrize("line", ["[open", "[]", "[ ]", "= 5"])
def test_a_bad_line_is_named(line):
    with pytest.raises(UsageError, match=r"camera.ini, line 2"):
        ini.parse(f"good 1\n{line}\n", "camera.ini")


@given(st.text(max_size=300))
def test_any_text_is_read_or_refused(text):
    try:
        sections = ini.parse(text)
    except UsageError:
        return
    assert all(section.name == name for name, section in sections.items())


def test_an_endless_file_is_refused():
    with pytest.raises(UsageError, match="too long"):
        ini.parse("x 1\n" * 1_000_000)


def test_the_search_order(tmp_path, monkeypatch):
    here, home, system = tmp_path / "here", tmp_path / "config", tmp_path / "system"
    places = [
        here / "camera.ini",
        home / "contexts" / "head" / "camera.ini",
        system / "contexts" / "head" / "camera.ini",
        home / "camera.ini",
    ]
    for place in places:
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text("index 0\n")
    monkeypatch.chdir(here)
    environment = {"YARP_CONFIG_HOME": str(home), "YARP_CONFIG_DIRS": str(system), "HOME": str(tmp_path)}

    for place in places:
        assert ini.find("camera.ini", "head", environment) == place
        place.unlink()
    with pytest.raises(UsageError, match=r"no configuration file camera.ini; looked in .*contexts/head"):
        ini.find("camera.ini", "head", environment)


def test_an_absolute_path_is_itself(tmp_path):
    (tmp_path / "a.ini").write_text("")

    assert ini.find(str(tmp_path / "a.ini")) == tmp_path / "a.ini"
    with pytest.raises(UsageError, match="no configuration file"):
        ini.find(str(tmp_path / "b.ini"))

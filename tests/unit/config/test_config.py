"""Configuration files as YARP writes and finds them; options of `serve`; which addresses are answered."""

import logging
from dataclasses import fields

import pytest
from hypothesis import given
from hypothesis import strategies as st

from every_case import every_case
from grabbergui.config.allowed_addresses import EVERYBODY, AllowedAddresses
from grabbergui.config.ini_files import find_ini, parse_ini
from grabbergui.config.serve_options import ServeOptions
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
    sections = parse_ini(CAMERA_INI)

    assert sections[""].values == {
        "device": "AravisCamera", "index": "0", "pixelFormat": "Mono 8", "introspection": "false", "fake": "",
    }  # fmt: skip
    assert sections["YARP_CAMERA right"].values == {"period": "0.033", "name": "/right image"}


@pytest.mark.parametrize("line", ["[open", "[]", "[ ]", "= 5"])
def test_a_bad_line_is_named(line):
    with pytest.raises(UsageError, match=r"camera.ini, line 2"):
        parse_ini(f"good 1\n{line}\n", "camera.ini")


@given(st.text(max_size=300))
def test_any_text_is_read_or_refused(text):
    try:
        sections = parse_ini(text)
    except UsageError:
        return
    assert all(section.name == name for name, section in sections.items())


def test_an_endless_file_is_refused():
    with pytest.raises(UsageError, match="too long"):
        parse_ini("x 1\n" * 1_000_000)


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
        assert find_ini("camera.ini", "head", environment) == place
        place.unlink()
    with pytest.raises(UsageError, match=r"no configuration file camera.ini; looked in .*contexts/head"):
        find_ini("camera.ini", "head", environment)


def test_an_absolute_path_is_itself(tmp_path):
    (tmp_path / "a.ini").write_text("")

    assert find_ini(str(tmp_path / "a.ini")) == tmp_path / "a.ini"
    with pytest.raises(UsageError, match="no configuration file"):
        find_ini(str(tmp_path / "b.ini"))


def section(text):
    return parse_ini(text)[""]


def test_the_reference_devices_keys():
    text = "device AravisCamera\nindex 2\nfake\npixelFormat BayerRG8\nintrospection true\nterminal 0\n"

    options = ServeOptions().with_file(section(text), frozenset(), "camera.ini")

    assert (options.index, options.fake, options.pixel_format) == (2, True, "BayerRG8")
    assert (options.introspection, options.terminal) == (True, False)
    assert options.uri == "sim:"


def test_the_command_line_wins():
    options = ServeOptions(yarp="/mine").with_file(
        section("yarp /grabber\nperiod 0.1"), frozenset({"yarp"}), "camera.ini"
    )

    assert (options.yarp, options.period) == ("/mine", 0.1)


def test_a_file_takes_every_option_under_its_name_on_the_command_line(caplog):
    for option in fields(ServeOptions):
        text = {"bool": "1", "int": "2", "float": "0.5"}.get(str(option.type), "x")
        for key in (option.name, option.name.replace("_", "-")):
            options = ServeOptions().with_file(section(f"{key} {text}"), frozenset(), "camera.ini")
            assert str(getattr(options, option.name)) in (text, "True"), key
    assert not caplog.text


def test_an_unknown_key_names_the_nearest(caplog):
    with caplog.at_level(logging.WARNING):
        options = ServeOptions().with_file(section("pixelformat Mono8"), frozenset(), "camera.ini")

    assert "unknown key 'pixelformat'" in caplog.text and "did you mean pixel_format?" in caplog.text
    assert options == ServeOptions()


def test_a_bad_value_is_refused():
    with pytest.raises(UsageError, match=r"camera.ini: index two"):
        ServeOptions().with_file(section("index two"), frozenset(), "camera.ini")


@every_case(
    ("peer", "allowed"),
    [
        ("10.0.0.7", True),
        ("10.0.1.7", False),
        ("192.168.1.7", True),
        ("192.168.1.8", False),
        ("fd00::5", True),
        ("fd01::5", False),
        ("fd00::5%eth0", True),
        ("::ffff:10.0.0.7", True),
        ("127.0.0.1", True),
        ("::1", True),
        ("nonsense", False),
        ("", False),
    ],
)
def test_the_addresses_whose_requests_are_answered(peer, allowed):
    addresses = AllowedAddresses.parse(["10.0.0.9/24", "192.168.1.7", "fd00::/64"])
    assert addresses.allows(peer, "172.16.0.1") is allowed
    assert addresses.allows(peer, peer), "this machine, by its own address"
    assert EVERYBODY.allows(peer)
    assert EVERYBODY.everybody and not addresses.everybody
    assert str(addresses) == "10.0.0.0/24, 192.168.1.7/32, fd00::/64"


@pytest.mark.parametrize("text", ["::ffff:10.0.0.1", "::ffff:10.0.0.0/120"])
@pytest.mark.parametrize("peer", ["10.0.0.1", "::ffff:10.0.0.1"])
def test_an_ipv4_address_may_be_written_as_an_ipv6_one(text, peer):
    addresses = AllowedAddresses.parse([text])
    assert addresses.allows(peer)
    assert not addresses.allows("10.0.1.1")


@pytest.mark.parametrize("text", ["10.0.0", "10.0.0.0/33", "host", ""])
def test_an_invalid_address_is_refused(text):
    with pytest.raises(UsageError, match="write an address or a network"):
        AllowedAddresses.parse([text])

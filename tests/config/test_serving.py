"""Options from a file under those of the command line; which addresses are answered."""

import logging

import pytest

from grabbergui.config import ini
from grabbergui.config.serving import EVERYBODY, AllowedAddresses, ServeOptions
from grabbergui.core.errors import UsageError


def section(text):
    return ini.parse(text)[""]


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


def test_an_unknown_key_names_the_nearest(caplog):
    with caplog.at_level(logging.WARNING):
        options = ServeOptions().with_file(section("pixelformat Mono8"), frozenset(), "camera.ini")

    assert "unknown key 'pixelformat'" in caplog.text and "did you mean pixelFormat?" in caplog.text
    assert options == ServeOptions()


def test_a_bad_value_is_refused():
    with pytest.raises(UsageError, match=r"camera.ini: index two"):
        ServeOptions().with_file(section("index two"), frozenset(), "camera.ini")


@pytest.mark.parametrize(
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
def test_who_is_answered(peer, allowed):
    addresses = AllowedAddresses.parse(["10.0.0.9/24", "192.168.1.7", "fd00::/64"])
    assert addresses.allows(peer, "172.16.0.1") is allowed
    assert addresses.allows(peer, peer), "this machine, by its own address"
    assert EVERYBODY.allows(peer)
    assert EVERYBODY.everybody and not addresses.everybody
    assert str(addresses) == "10.0.0.0/24, 192.168.1.7/32, fd00::/64"


@pytest.mark.parametrize("text", ["10.0.0", "10.0.0.0/33", "host", ""])
def test_what_is_no_address(text):
    with pytest.raises(UsageError, match="write an address or a network"):
        AllowedAddresses.parse([text])

"""Options from a file under those of the command line."""

import logging

import pytest

from grabbergui.config import ini
from grabbergui.config.serve_options import ServeOptions
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

"""The simulated camera's look-up table changes the image, and is its file as well."""

import numpy as np
import pytest

from grabbergui import sources
from grabbergui.core.file_access import delete_file, read_file, write_file
from patience import PATIENCE, until


@pytest.fixture
def camera():
    grabber = sources.create("sim:?width=160&height=120&fps=50")
    grabber.open()
    yield grabber
    grabber.close()


@pytest.mark.parametrize("pixel_format", ["Mono8", "Mono12p", "BayerRG8", "RGB8"])
def test_it_replaces_values_of_every_depth_while_it_is_on(camera, pixel_format):
    camera.write_feature("PixelFormat", pixel_format)
    inverted = (65535 - np.arange(4096) * 16).astype(">u2")
    camera.write_register("LUTValueAll", inverted.tobytes())
    queue = camera.open_queue(2)
    camera.start()
    before = queue.get(PATIENCE).rgb().mean()
    camera.write_feature("LUTEnable", True)
    until(lambda: abs(queue.get(PATIENCE).rgb().mean() - (255 - before)) < 12)
    camera.write_feature("LUTEnable", False)
    until(lambda: abs(queue.get(PATIENCE).rgb().mean() - before) < 12)


def test_the_linear_table_changes_nothing(camera):
    queue = camera.open_queue(2)
    camera.start()
    before = queue.get(PATIENCE).raw().mean()
    camera.write_feature("LUTEnable", True)
    for _ in range(4):
        after = queue.get(PATIENCE).raw().mean()
    assert abs(before - after) < 2


def test_file_registers_and_entries_are_one_table(camera):
    camera.write_feature("LUTIndex", 100)
    assert camera.feature("LUTValue").value == 1600
    camera.write_feature("LUTValue", 5)
    assert np.frombuffer(camera.read_register("LUTValueAll", 8192), ">u2")[100] == 5
    assert np.frombuffer(read_file(camera, "LUTLuminance"), "<u2")[100] == 5
    write_file(camera, "LUTLuminance", np.full(4096, 77, "<u2").tobytes())
    assert camera.feature("LUTValue").value == 77
    delete_file(camera, "LUTLuminance")
    assert camera.feature("LUTValue").value == 1600, "without a file values pass unchanged"
    assert read_file(camera, "LUTLuminance") == b""

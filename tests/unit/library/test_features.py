"""Names of features: the camera's own, Python's and SFNC's mean the same everywhere."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import grabbergui
from fakes import ScriptedGrabber
from grabbergui.core.features import AccessMode, Feature, FeatureKind, Representation
from patience import attempts


@pytest.mark.parametrize("name", ["ExposureTime", "exposure_time", "Exposure_Time"])
@pytest.mark.parametrize(
    "value_of",
    [
        lambda camera, name: camera[name],
        lambda camera, name: getattr(camera, name),
        lambda camera, name: camera.read(name),
        lambda camera, name: camera.feature(name).value,
        lambda camera, name: name in camera and camera.write(name, 1234),
        lambda camera, name: camera.grab(**{name: 1234}).chunks["ChunkExposureTime"],
        lambda camera, name: camera.bracket(**{name: [1234]})[0].chunks["ChunkExposureTime"],
    ],
    ids=["item", "attribute", "read", "feature", "in, write", "grab", "bracket"],
)
def test_every_spelling_means_the_feature(
    camera: grabbergui.Camera, name: str, value_of: Callable[[Any, str], Any]
) -> None:
    camera.exposure_time = 1234
    assert value_of(camera, name) == 1234.0


def test_selectors_and_commands_have_every_spelling(camera: grabbergui.Camera) -> None:
    camera["trigger_delay[trigger_selector=FrameBurstStart]"] = 500
    assert camera["TriggerDelay[TriggerSelector=FrameBurstStart]"] == 500.0
    camera.execute("timestamp_latch")
    camera.ExposureTime = 2000
    assert camera.exposure_time == 2000.0
    assert (
        "DeviceUserID" in camera
        and "device_user_id" in camera
        and "no such" not in camera
        and 5 not in camera
    )


def test_sfnc_s_name_means_an_older_camera_s_own() -> None:
    exposure = Feature(
        name="ExposureTimeAbs", kind=FeatureKind.FLOAT, access=AccessMode.READ_WRITE, value=1000.0
    )
    camera = grabbergui.Camera(ScriptedGrabber([exposure]))
    assert camera.exposure_time == camera["ExposureTime"] == camera["exposure_time_abs"] == 1000.0
    camera.ExposureTime = 2000.0
    assert camera["ExposureTimeAbs"] == 2000.0


@pytest.mark.parametrize(
    ("representation", "number", "text"),
    [
        (Representation.IPV4_ADDRESS, 0xC0A8000A, "192.168.0.10"),
        (Representation.MAC_ADDRESS, 0x003053123456, "00:30:53:12:34:56"),
        (Representation.HEX_NUMBER, 0x1F, "0x1F"),
        (Representation.PURE_NUMBER, 31, 31),
    ],
)
def test_addresses_are_returned_as_they_are_written(
    representation: Representation, number: int, text: str | int
) -> None:
    address = Feature(
        name="Address",
        kind=FeatureKind.INTEGER,
        access=AccessMode.READ_WRITE,
        value=number,
        representation=representation,
    )
    camera = grabbergui.Camera(ScriptedGrabber([address]))
    assert camera.address == camera["Address"] == camera.write("Address", text) == text


def test_a_misspelled_setting_is_refused_at_once(camera: grabbergui.Camera) -> None:
    for watch in attempts(1.0):
        with watch:
            for grab in (lambda: camera.grab(exposure_tme=1), lambda: camera.bracket(ExposureTme=[1])):
                with pytest.raises(grabbergui.FeatureNotFoundError, match="did you mean ExposureTime"):
                    grab()
    assert not camera.streaming


@pytest.mark.parametrize("value", [np.float32(1500), np.float64(1500), np.int32(1500), np.uint8(150)])
def test_numpy_s_numbers_are_values(camera: grabbergui.Camera, value: np.generic) -> None:
    camera.exposure_time = value
    assert camera.exposure_time == float(value)

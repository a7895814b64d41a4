"""Closed, lost, streaming: what a camera says of itself, and the errors that a program catches."""

from __future__ import annotations

import pickle
import threading

import numpy as np
import pytest

import grabbergui
from grabbergui.core.errors import ClosedError
from grabbergui.library.camera import Camera
from patience import PATIENCE


@pytest.mark.parametrize(
    "use",
    [
        lambda camera: camera.grab(),
        lambda camera: camera.exposure_time,
        lambda camera: camera.start(),
        lambda camera: next(iter(camera.frames())),
        lambda camera: camera.files.list(),
        lambda camera: camera.on("lost", print),
        lambda camera: camera.record("never.mcap"),
        lambda camera: "Gain" in camera,
    ],
    ids=["grab", "read", "start", "frames", "files", "on", "record", "in"],
)
def test_a_closed_camera_says_that_it_is_closed(camera: grabbergui.Camera, use) -> None:
    camera.close()
    with pytest.raises(ClosedError, match=r"was closed by this program; open it again|is closed"):
        use(camera)
    assert camera.state == "closed" and "closed" in repr(camera) and not camera.streaming
    assert camera.info.serial == "SIM001"
    camera.close()


def test_a_wait_for_a_frame_ends_when_the_camera_is_closed(camera: grabbergui.Camera) -> None:
    camera["TriggerMode"] = "On"
    threading.Timer(0.2, camera.close).start()
    with pytest.raises(ClosedError, match="was closed"):
        camera.grab(timeout=PATIENCE)


def test_the_state_and_the_text_of_a_camera(camera: grabbergui.Camera) -> None:
    assert camera.state == "open" and repr(camera).endswith("SIM001, open>")
    camera.grab()
    assert camera.state == "streaming" and "streaming at" in repr(camera)
    camera.stop()
    assert camera.state == "open"


@pytest.mark.parametrize(
    ("error", "python"),
    [
        (grabbergui.FrameTimeoutError, TimeoutError),
        (grabbergui.FeatureNotFoundError, KeyError),
        (grabbergui.FeatureValueError, ValueError),
        (grabbergui.UsageError, ValueError),
        (grabbergui.PixelFormatError, ValueError),
        (grabbergui.ClosedError, ValueError),
        (grabbergui.AccessDeniedError, PermissionError),
        (grabbergui.SourceNotFoundError, LookupError),
        (grabbergui.MissingFileError, FileNotFoundError),
        (grabbergui.ExistingFileError, FileExistsError),
    ],
)
def test_an_error_is_what_python_has_for_it_too(error: type[Exception], python: type[Exception]) -> None:
    assert issubclass(error, python) and issubclass(error, grabbergui.GrabberError)


def test_the_errors_of_calls(camera: grabbergui.Camera) -> None:
    with pytest.raises(KeyError) as missing:
        camera.read("NoSuch")
    assert str(missing.value).startswith("grabbergui Simulated camera SIM001 has no feature NoSuch")
    with pytest.raises(ValueError, match="depth=0"):
        camera.frames(depth=0)
    camera["TriggerMode"] = "On"
    with pytest.raises(TimeoutError, match="waits for a trigger"):
        camera.grab(timeout=0.05)


def test_a_camera_is_no_sequence_of_frames(camera: grabbergui.Camera) -> None:
    with pytest.raises(TypeError, match=r"for frame in camera\.frames\(\)"):
        for _ in camera:  # type: ignore[attr-defined]
            pass
    with pytest.raises(grabbergui.UsageError, match=r"grabbergui\.open\('gige:'\)"):
        Camera("gige:")  # type: ignore[arg-type]


def test_a_frame_is_an_array_and_has_opencv_s_order() -> None:
    with grabbergui.open("sim:colour?width=64&height=48&fps=100&exposure=1000") as camera:
        frame = camera.grab()
    array = np.asarray(frame)
    assert array.dtype == frame.raw().dtype and np.shares_memory(array, frame.raw())
    assert np.asarray(frame, np.float32).dtype == np.float32
    assert np.array(frame).flags.writeable
    assert (frame.bgr()[..., ::-1] == frame.rgb()).all() and frame.bgr().flags.c_contiguous
    component = frame.components[0]
    assert (np.asarray(component) == array).all() and (component.bgr() == frame.bgr()).all()
    with pytest.raises(ValueError, match="copy"):
        np.asarray(frame, np.float32, copy=False)
    assert pickle.loads(pickle.dumps(frame)).bgr().shape == (48, 64, 3)

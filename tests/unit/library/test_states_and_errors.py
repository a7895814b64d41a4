"""Closed, lost, streaming: what a camera says of itself, and the errors that a program catches."""

from __future__ import annotations

import pickle
import re
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import grabbergui
from every_case import every_case
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


def test_the_methods_of_a_closed_camera_are_listed(camera: grabbergui.Camera) -> None:
    assert {"grab", "trigger_mode"} <= set(dir(camera))
    camera.close()
    assert "grab" in dir(camera) and "trigger_mode" not in dir(camera)


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


@every_case(
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
        (grabbergui.LocalFileError, OSError),
        (grabbergui.MissingFrameError, KeyError),
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


@pytest.mark.parametrize(
    ("call", "refused"),
    [
        (lambda camera: camera.frames("10"), r"frames\('10'\): the number of frames is 0 or more"),
        (lambda camera: camera.frames(2.5), r"frames\(2.5\): the number of frames is 0 or more"),
        (lambda camera: camera.frames(depth="8"), r"frames\(depth='8'\): at least one frame"),
        (lambda camera: camera.frames(timeout=-1), r"frames\(timeout=-1\): the time-out is in seconds"),
        (lambda camera: camera.grab("ExposureTime"), r"grab\(timeout='ExposureTime'\): the time-out is in"),
        (lambda camera: camera.trigger(timeout=float("nan")), r"trigger\(timeout=nan\): the time-out is in"),
        (lambda camera: camera.on("change", 3), r"on\('change', 3\): the second argument is a function"),
        (lambda camera: camera.files.write("UserSet1", "text"), "the content is bytes, or a pathlib.Path"),
    ],
)
def test_an_argument_of_the_wrong_kind_is_named(
    camera: grabbergui.Camera, call: Callable[[grabbergui.Camera], object], refused: str
) -> None:
    with pytest.raises(grabbergui.UsageError, match=refused):
        call(camera)


def test_numpy_counts_frames(camera: grabbergui.Camera) -> None:
    assert len(list(camera.frames(np.int64(2), depth=np.uint8(4), timeout=np.float32(5)))) == 2


@pytest.mark.parametrize(
    "use",
    [
        lambda camera, path: camera.save_settings(path),
        lambda camera, path: camera.load_settings(path),
        lambda camera, path: camera.files.write("UserSet1", path),
    ],
)
def test_a_folder_in_place_of_a_file_is_an_error_of_the_tree(
    camera: grabbergui.Camera, use: Callable[[grabbergui.Camera, Path], object], tmp_path: Path
) -> None:
    with pytest.raises((grabbergui.LocalFileError, grabbergui.UsageError), match=re.escape(str(tmp_path))):
        use(camera, tmp_path)


@pytest.mark.parametrize(
    "use",
    [
        lambda camera, path: camera.save_settings(path),
        lambda camera, path: camera.load_settings(path),
        lambda camera, path: camera.files.write("UserSet1", path),
    ],
)
def test_a_file_that_is_not_there_is_an_error_of_the_tree(
    camera: grabbergui.Camera, use: Callable[[grabbergui.Camera, Path], object], tmp_path: Path
) -> None:
    with pytest.raises(grabbergui.MissingFileError, match=re.escape(str(tmp_path / "no"))):
        use(camera, tmp_path / "no" / "file.yaml")


def test_a_taken_name_is_said_once(camera: grabbergui.Camera, tmp_path: Path) -> None:
    taken = tmp_path / "run.mcap"
    taken.write_bytes(b"x")
    with pytest.raises(FileExistsError) as refused:
        camera.record(taken, frames=1)
    assert str(refused.value) == (
        f"{taken} is there already; a recording overwrites nothing, choose another name"
    )


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

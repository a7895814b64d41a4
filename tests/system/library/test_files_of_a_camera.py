"""Files of a camera object: recordings, settings, points, and files in the camera."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import grabbergui
from grabbergui.core.errors import PixelFormatError, UsageError
from patience import PATIENCE, until


@pytest.mark.parametrize("name", ["run.mcap", "run.mp4", "run"])
def test_a_recording_holds_every_frame(camera: grabbergui.Camera, tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    done = camera.record(path, frames=10).wait(PATIENCE)
    assert (done.frames, done.dropped) == (10, 0) and not camera.streaming
    with grabbergui.open(f"file:{path}") as played:
        assert len(list(played.frames(10))) == 10


@pytest.mark.parametrize(
    ("name", "options", "pixel_format", "file"),
    [
        ("run.mp4", {"codec": "ffv1"}, "Mono12", "run.mp4"),
        ("run.mp4", {"lossless": True}, "Mono8", "run.mp4"),
        ("run", {"tiff": True}, "Mono12", "run/00000000.tiff"),
    ],
)
def test_a_recording_keeps_what_its_options_promise(
    camera: grabbergui.Camera,
    tmp_path: Path,
    name: str,
    options: dict[str, Any],
    pixel_format: str,
    file: str,
) -> None:
    camera.pixel_format = pixel_format
    camera.record(tmp_path / name, frames=2, **options).wait(PATIENCE)
    assert (tmp_path / file).is_file()
    with grabbergui.open(f"file:{tmp_path / name}") as played:
        assert played.grab().pixel_format.name == pixel_format


def test_a_recording_ends_at_its_size(camera: grabbergui.Camera, tmp_path: Path) -> None:
    done = camera.record(tmp_path / "run.mcap", megabytes=0.05).wait(PATIENCE)
    assert done.ended and done.frames > 2 and 0.05e6 <= done.size < 0.1e6


def test_files_may_be_in_the_home_directory(
    camera: grabbergui.Camera, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    camera.record("~/data/run.mcap", frames=1).wait(PATIENCE)
    camera.save_settings("~/data/camera.yaml")
    assert camera.load_settings("~/data/camera.yaml").settled
    assert sorted(path.name for path in (tmp_path / "data").iterdir()) == ["camera.yaml", "run.mcap"]
    with grabbergui.open("file:~/data/run.mcap") as played:
        assert played.grab().complete


def test_a_recording_lasts_as_long_as_its_block(camera: grabbergui.Camera, tmp_path: Path) -> None:
    with camera.record(tmp_path / "run.mcap") as recording:
        until(lambda: recording.progress.frames >= 3)
    assert recording.progress.ended and not camera.streaming
    with pytest.raises(grabbergui.GrabberError, match="there already"):
        camera.record(tmp_path / "run.mcap")


@pytest.mark.parametrize("name", ["camera.yaml", "camera.txt"])
def test_settings_are_saved_and_loaded(camera: grabbergui.Camera, tmp_path: Path, name: str) -> None:
    camera.exposure_time, camera.gain = 3000, 6
    camera.save_settings(tmp_path / name)
    camera.exposure_time, camera.gain = 1000, 0
    assert camera.load_settings(tmp_path / name, dry_run=True).count() == 0
    report = camera.load_settings(tmp_path / name)
    assert report.settled, report.lines()
    assert (camera.exposure_time, camera.gain) == (3000.0, 6.0)


def test_files_in_the_camera(camera: grabbergui.Camera, tmp_path: Path) -> None:
    assert "LUTLuminance" in [file.name for file in camera.files.list()]
    table = np.frombuffer(camera.files.read("LUTLuminance"), "<u2")
    half = (table // 2).tobytes()
    assert camera.files.write("LUTLuminance", half).verified
    assert camera.files.read("LUTLuminance") == half
    (tmp_path / "table.bin").write_bytes(table.tobytes())
    camera.files.write("LUTLuminance", tmp_path / "table.bin")
    assert camera.files.read("LUTLuminance") == table.tobytes()
    camera.files.delete("ShadingCorrection")
    assert camera.files.read("ShadingCorrection") == b""
    with pytest.raises(UsageError, match="replace_firmware"):
        camera.files.write("Firmware", b"")
    with pytest.raises(grabbergui.CameraFileError, match="DeviceLog"):
        camera.files.write("DeviceLog", b"")


def test_the_points_of_a_frame_and_its_distances(tmp_path):
    with grabbergui.open("sim:") as camera:
        camera.width, camera.height = 64, 48
        camera["ComponentSelector"] = "Range"
        camera["ComponentEnable"] = True
        frame = camera.grab()
        distance = camera.distances(frame.components[1])
        assert np.array_equal(camera.distances(frame), distance, equal_nan=True)
        with pytest.raises(PixelFormatError, match="INTENSITY of Mono8 is no range image"):
            camera.distances(frame.components[0])
        cloud = camera.points(frame)
        camera.save_points(frame, tmp_path / "cloud.ply")
        with pytest.raises(grabbergui.MissingFileError, match="there is no folder"):
            camera.save_points(frame, tmp_path / "no" / "cloud.ply")
        with pytest.raises(grabbergui.LocalFileError, match="could not be written"):
            camera.save_points(frame, tmp_path)
        camera["ComponentEnable"] = False
        with pytest.raises(PixelFormatError, match="has no range image; switch on ComponentEnable"):
            camera.distances(camera.grab())
    assert distance.shape == (48, 64) and 550 < np.nanmin(distance) < np.nanmax(distance) < 1500
    assert len(cloud.points) == np.isfinite(distance).sum() == len(cloud.colours)
    assert (tmp_path / "cloud.ply").stat().st_size > 15 * len(cloud.points)

"""The frame that was taken with a setting: by chunk data, or by counting."""

from __future__ import annotations

import itertools
import os
import random
from collections.abc import Iterator
from contextlib import closing
from typing import Any

import numpy as np
import pytest

import grabbergui
from grabbergui.core.errors import GrabberError
from grabbergui.core.frame import Frame, FrameStatus
from grabbergui.core.pfnc import by_name
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige.server import GigeCamera
from grabbergui.library import effect
from grabbergui.library.effect import SettingEffect

ADDRESS = "127.20.1.2"
FAST = "width=64&height=48&fps=200"
GRABS = int(os.environ.get("GRABBERGUI_GRABS", "60"))
"Frames taken with a setting, for each way; 1000 for the figure in the manual."


def frame(captured: float, *, complete: bool = True, **chunks: float) -> Frame:
    return Frame(
        payload=np.zeros(4, np.uint8),
        width=2,
        height=2,
        pixel_format=by_name("Mono8"),
        captured=captured,
        status=FrameStatus.COMPLETE if complete else FrameStatus.INCOMPLETE,
        chunks={f"Chunk{name}": value for name, value in chunks.items()},
    )


def first_accepted(setting: SettingEffect, frames: list[Frame]) -> int:
    return next(index for index, each in enumerate(frames) if setting.accepts(each))


def test_without_settings_the_first_frame_after_the_call_is_taken() -> None:
    setting = SettingEffect({}, 10.0, 10.0, latency=3)
    assert first_accepted(setting, [frame(9.9), frame(10.1), frame(10.2)]) == 1


def test_frames_are_counted_from_the_acknowledge_on() -> None:
    setting = SettingEffect({"ExposureTime": 5000.0}, 10.0, 10.1, latency=2)
    times = (9.9, 10.05, 10.11, 10.15, 10.2, 10.25)
    assert first_accepted(setting, [frame(at) for at in times]) == 4


def test_chunk_data_decide_where_a_frame_has_them() -> None:
    setting = SettingEffect({"ExposureTime": 5000.0}, 10.0, 10.1, latency=0)
    exposures = (1000.0, 1000.0, 1000.0, 5000.2)
    frames = [frame(10.2 + n / 10, ExposureTime=exposure) for n, exposure in enumerate(exposures)]
    assert first_accepted(setting, frames) == 3


def test_an_older_frame_that_happens_to_be_exposed_so_is_not_taken() -> None:
    setting = SettingEffect({"ExposureTime": 5000.0}, 10.0, 10.1, latency=0)
    assert not setting.accepts(frame(9.9, ExposureTime=5000.0))


def test_an_incomplete_frame_is_never_taken() -> None:
    setting = SettingEffect({"ExposureTime": 5000.0}, 10.0, 10.1, latency=0)
    assert not setting.accepts(frame(10.5, complete=False, ExposureTime=5000.0))


def test_what_no_chunk_reports_is_counted_and_what_one_reports_must_agree() -> None:
    setting = SettingEffect({"ExposureTime": 5000.0, "BlackLevel": 2.0}, 10.0, 10.1, latency=1)
    frames = [
        frame(10.2, ExposureTime=5000.0),
        frame(10.3, ExposureTime=1.0),
        frame(10.4, ExposureTime=5000.0),
    ]
    assert first_accepted(setting, frames) == 2


def test_chunk_data_that_never_agree_are_an_error_that_names_both_values() -> None:
    setting = SettingEffect({"Gain": 3.0}, 10.0, 10.1, latency=0)
    with pytest.raises(GrabberError, match=r"Gain is 3\.0 and the chunk data say 1\.5"):
        for count in range(effect.MOST_REFUSED + 1):
            setting.accepts(frame(10.2 + count, Gain=1.5))


@pytest.fixture
def camera(request: Any) -> Iterator[grabbergui.Camera]:
    with grabbergui.open(f"sim:?{FAST}&exposure=1000&setting_latency={request.param}") as camera:
        yield camera


@pytest.fixture
def gige_camera() -> Iterator[grabbergui.Camera]:
    small = {reg.WIDTH: 64, reg.HEIGHT: 48, reg.FRAME_RATE: 100.0, reg.EXPOSURE_TIME: 1000.0}
    with (
        closing(GigeCamera(ADDRESS, power_on={**small, reg.SETTING_LATENCY: 2})),
        grabbergui.open(f"gige:{ADDRESS}") as camera,
    ):
        yield camera


def taken_rightly(camera: grabbergui.Camera, count: int) -> int:
    """Grab with random exposure times; return how many frames were exposed so, as their chunk data say."""
    rng = random.Random(5)
    right = 0
    for _ in range(count):
        exposure = rng.choice((500.0, 1000.0, 2000.0, 4000.0))
        right += camera.grab(ExposureTime=exposure).chunks["ChunkExposureTime"] == exposure
    return right


@pytest.mark.parametrize("camera", [1, 2, 4], indirect=True)
def test_every_frame_was_exposed_as_asked_by_chunk_data(camera: grabbergui.Camera) -> None:
    assert taken_rightly(camera, GRABS) == GRABS


@pytest.mark.parametrize("camera", [1, 4], indirect=True)
def test_every_frame_was_exposed_as_asked_by_counting(
    camera: grabbergui.Camera, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(effect, "chunk_value", lambda frame, name: None)
    assert taken_rightly(camera, GRABS) == GRABS


def test_every_frame_of_a_gige_camera_was_exposed_as_asked(
    gige_camera: grabbergui.Camera, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert taken_rightly(gige_camera, GRABS) == GRABS
    monkeypatch.setattr(effect, "chunk_value", lambda frame, name: None)
    assert taken_rightly(gige_camera, GRABS) == GRABS


@pytest.mark.parametrize("camera", [1], indirect=True)
def test_a_bracket_switches_an_automatic_mode_on_again(camera: grabbergui.Camera) -> None:
    camera["ExposureAuto"] = "Continuous"
    camera["Gain"] = 6
    camera.bracket(ExposureTime=[2000, 8000], Gain=[0, 3])
    assert (camera["ExposureAuto"], camera["Gain"]) == ("Continuous", 6)


@pytest.mark.parametrize("camera", [2], indirect=True)
def test_a_bracket_is_exposed_as_asked_and_leaves_the_camera_as_it_was(camera: grabbergui.Camera) -> None:
    before = camera.exposure_time
    exposures = [500.0, 2000.0, 4000.0]
    frames = camera.bracket(ExposureTime=exposures, Gain=[0, 3, 6])
    assert [frame.chunks["ChunkExposureTime"] for frame in frames] == exposures
    assert [frame.chunks["ChunkGain"] for frame in frames] == [0.0, 3.0, 6.0]
    assert (camera.exposure_time, camera.gain) == (before, 0.0)
    assert all(late.frame_id > early.frame_id for early, late in itertools.pairwise(frames))


def test_chunk_data_that_were_switched_on_are_switched_off_at_the_end() -> None:
    camera = grabbergui.open(f"sim:?{FAST}")
    seen: list[tuple[str, object]] = []
    with camera:
        camera.grab(ExposureTime=1000)
        assert camera["ChunkModeActive"] is True
        write = camera.grabber.write_setting
        camera.grabber.write_setting = lambda key, value: (seen.append((str(key), value)), write(key, value))[
            1
        ]  # type: ignore
    assert seen == [("ChunkModeActive", False)]

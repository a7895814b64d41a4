"""What a camera object reports to callbacks: changes, events, loss and return."""

from __future__ import annotations

import threading
from typing import Any

import pytest

import grabbergui
from fakes import ScriptedGrabber
from grabbergui.core.errors import ClosedError, UsageError
from grabbergui.library import callbacks as reports
from patience import PATIENCE, until


def test_changes_reach_a_callback_that_may_use_the_camera(camera: grabbergui.Camera) -> None:
    seen: list[tuple[frozenset[str], Any]] = []
    end = camera.on("change", lambda names: seen.append((names, camera.exposure_time)))
    camera.exposure_time = 3000
    until(lambda: any("ExposureTime" in names and value == 3000.0 for names, value in seen))
    end()
    end()
    seen.clear()
    camera.exposure_time = 4000
    with pytest.raises(UsageError, match="change, event, lost"):
        camera.on("loss", print)  # type: ignore[arg-type]
    assert not seen


def test_a_closed_camera_takes_no_callbacks(camera: grabbergui.Camera) -> None:
    camera.close()
    threads = threading.active_count()
    with pytest.raises(ClosedError, match="is closed"):
        camera.on("lost", print)
    assert threading.active_count() <= threads


def test_events_reach_a_callback(camera: grabbergui.Camera) -> None:
    seen: list[grabbergui.DeviceEvent] = []
    camera.on("event", seen.append)
    camera["EventNotification[EventSelector=Test]"] = "On"
    camera.execute("TestEventGenerate")
    assert until(lambda: seen)[0].name == "Test"


def test_a_failing_callback_hinders_no_other(camera: grabbergui.Camera) -> None:
    seen: list[object] = []
    camera.on("change", lambda names: 1 / 0)
    camera.on("change", seen.append)
    camera.exposure_time = 3000
    until(lambda: seen)


def test_events_do_not_pile_up_behind_a_slow_callback(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(reports, "MOST_WAITING", 10)
    grabber, busy = ScriptedGrabber(), threading.Event()
    seen: list[str] = []
    callbacks = reports.Callbacks(grabber)

    def slow(event: grabbergui.DeviceEvent) -> None:
        seen.append(event.name)
        busy.wait(PATIENCE)

    callbacks.add("event", slow)
    grabber.event_received.emit(grabbergui.DeviceEvent("0", 0, {}))
    until(lambda: seen)
    for number in range(1, 1000):
        grabber.event_received.emit(grabbergui.DeviceEvent(str(number), number, {}))
    busy.set()
    until(lambda: len(seen) == 11)
    callbacks.close()
    assert seen == [str(number) for number in range(11)]
    assert [line for line in caplog.messages if "callbacks" in line] == [
        "Acme Script: the callbacks are too slow, so events are dropped"
    ]

"""`grabbergui events` on the simulated camera."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterator

import pytest

from grabbergui import sources
from grabbergui.cli import events, main
from grabbergui.core.grabber import FrameGrabber

SMALL = "sim:?width=64&height=48&fps=100"


def test_the_events_of_a_camera_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["events", SMALL]) == 0
    edges = ["Line1RisingEdge", "Line1FallingEdge"]
    named = ["FrameStart", "ExposureEnd", "FrameTriggerMissed", "Test", *edges]
    assert capsys.readouterr().out.split() == named


def test_reported_events_are_printed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["events", SMALL, "ExposureEnd", "FrameStart", "--start", "-n", "4", "--json"]) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert {line["event"] for line in lines} == {"ExposureEnd", "FrameStart"} and len(lines) == 4
    assert lines[0]["values"]["EventFrameStartFrameID"] == 1


def test_the_selector_is_restored(monkeypatch: pytest.MonkeyPatch) -> None:
    selected = []
    camera = sources.create(SMALL)

    @contextlib.contextmanager
    def opened(*_: object, **__: object) -> Iterator[FrameGrabber]:
        camera.open()
        camera.write_feature("EventSelector", "FrameStart")
        yield camera
        selected.append(camera.feature("EventSelector").value)
        camera.close()

    monkeypatch.setattr(events, "opened", opened)
    assert main(["events", SMALL, "ExposureEnd", "Test", "--duration", "0.1"]) == 0
    assert selected == ["FrameStart"]


def test_it_ends_in_time(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["events", SMALL, "Test", "--duration", "0.3"]) == 0
    assert capsys.readouterr().out == ""


def test_an_unknown_event_is_refused_with_those_there_are(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["events", SMALL, "Rain"]) == 1
    assert "it has FrameStart, ExposureEnd" in capsys.readouterr().err

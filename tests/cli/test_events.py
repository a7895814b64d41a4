"""`grabbergui events` on the simulated camera."""

from __future__ import annotations

import json

import pytest

from grabbergui.cli import main

SMALL = "sim:?width=64&height=48&fps=100"


def test_the_events_of_a_camera_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["events", SMALL]) == 0
    assert capsys.readouterr().out.split() == ["FrameStart", "ExposureEnd", "FrameTriggerMissed", "Test"]


def test_what_is_told_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["events", SMALL, "ExposureEnd", "FrameStart", "--start", "-n", "4", "--json"]) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert {line["event"] for line in lines} == {"ExposureEnd", "FrameStart"} and len(lines) == 4
    assert lines[0]["values"]["EventFrameStartFrameID"] == 1


def test_it_ends_in_time(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["events", SMALL, "Test", "--duration", "0.3"]) == 0
    assert capsys.readouterr().out == ""


def test_an_unknown_event_is_refused_with_those_there_are(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["events", SMALL, "Rain"]) == 1
    assert "it has FrameStart, ExposureEnd" in capsys.readouterr().err

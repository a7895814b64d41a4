"""Reports of every kind of source, as quickly as they can be had."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from grabbergui.core.grabber import FrameGrabber
from grabbergui.driver.twin import report_file
from grabbergui.driver.twin.report_file import CameraReport
from grabbergui.report import collect, computer
from grabbergui.report.collect import ReportOptions


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Reports without a search for cameras and without the doctor, which take seconds."""
    monkeypatch.setattr(computer, "network", lambda: {"interfaces": [], "discovery": []})
    monkeypatch.setattr(computer, "findings", list)


@pytest.fixture
def report_of(quick: None) -> Callable[..., CameraReport]:
    """Makes the report of a grabber, as it is read back from its file."""

    def make(grabber: FrameGrabber, *, frames: int = 5, pixels: bool = False) -> CameraReport:
        report = collect.report_of(grabber, ReportOptions(frames, pixels=pixels), lambda step: None)
        return report_file.decode(report_file.encode(report))

    return make

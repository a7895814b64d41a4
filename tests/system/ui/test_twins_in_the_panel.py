"""The panel on twins of vendors' cameras; with GRABBERGUI_ALL_TWINS=1 of all, otherwise of one."""

import logging
import os
from pathlib import Path

import pytest

from fakes import XmlDevice
from grabbergui.core.features import Category, Visibility
from grabbergui.driver.device_grabber import DeviceGrabber
from grabbergui.driver.twin.device import device_of
from grabbergui.report import collect, computer
from grabbergui.report.collect import ReportOptions

FOLDER = Path(
    os.environ.get("GRABBERGUI_GENICAM_XML", Path(__file__).parents[3].parent / "shared" / "genicam-xml")
)
ALL = os.environ.get("GRABBERGUI_ALL_TWINS", "") not in ("", "0")
DESCRIPTIONS = [path for path in sorted(FOLDER.glob("*.xml")) if ALL or path.stem == "Huaray_DS5131"]
NONE = [pytest.param(None, marks=pytest.mark.skip("no vendors' XML here; set GRABBERGUI_GENICAM_XML"))]


def reachable(category: Category) -> set[str]:
    names: set[str] = set()
    for member in category.members:
        if member.visibility <= Visibility.GURU:
            names |= reachable(member) if isinstance(member, Category) else {member.name}
    return names


@pytest.mark.parametrize("path", DESCRIPTIONS or NONE, ids=lambda path: path.stem if path else "none")
def test_tour_of_a_twin(make_panel, path, caplog, monkeypatch):
    monkeypatch.setattr(computer, "network", dict)
    monkeypatch.setattr(computer, "findings", list)
    report = collect.report_of(
        DeviceGrabber(XmlDevice(path.read_bytes())), ReportOptions(0), lambda step: None
    )
    camera = DeviceGrabber(device_of(report, "twin:file.zip", answer_times=False))
    camera.open()
    d = make_panel(camera)
    d.filled()
    d.open_everything()
    assert d.panel.watched == reachable(d.model.root)
    assert not [r for r in caplog.records if r.levelno >= logging.ERROR]

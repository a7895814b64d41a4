"""The panel on whole cameras: the simulated one, and the largest and the smallest description of a real one.

With GRABBERGUI_ALL_TWINS=1 of all.
"""

import logging
import os
import struct
import threading
import time
from pathlib import Path

import pytest
from PyQt5.QtCore import QPoint, Qt

from fakes import XmlDevice
from grabbergui import sources
from grabbergui.core.features import AccessMode, Category, Visibility
from grabbergui.driver.device_grabber import DeviceGrabber
from patience import attempts

HEAD = """<?xml version="1.0" encoding="utf-8"?>
<RegisterDescription xmlns="http://www.genicam.org/GenApi/Version_1_1" ModelName="V" VendorName="V"
 ToolTip="" StandardNameSpace="None" SchemaMajorVersion="1" SchemaMinorVersion="1" SchemaSubMinorVersion="0"
 MajorVersion="1" MinorVersion="0" SubMinorVersion="0" ProductGuid="1" VersionGuid="1">
<Port Name="Device"/>"""
ALL = os.environ.get("GRABBERGUI_ALL_TWINS", "") not in ("", "0")
EXPOSURE_REGISTER = 0x100330
"""The simulated camera's register: microseconds, a big-endian double."""


@pytest.fixture
def sim(make_panel):
    camera = sources.create("sim:?width=64&height=64")
    camera.open()
    return make_panel(camera)


def exposure_register(d):
    return struct.unpack(">d", d.grabber.device.read(EXPOSURE_REGISTER, 8))[0]


def reachable(category: Category) -> set[str]:
    names: set[str] = set()
    for member in category.members:
        if member.visibility <= Visibility.GURU:
            names |= reachable(member) if isinstance(member, Category) else {member.name}
    return names


def test_a_slider_moves_the_cameras_register(sim):
    slider = sim.row("ExposureTime", sim.strip).editor.slider()
    sim.qtbot.mouseClick(slider, Qt.LeftButton, pos=slider.rect().center() + QPoint(slider.width() // 4, 0))
    sim.qtbot.waitUntil(lambda: exposure_register(sim) > 10000)
    sim.qtbot.keyClick(slider, Qt.Key_End)
    sim.qtbot.waitUntil(lambda: exposure_register(sim) == 1e6)
    sim.qtbot.waitUntil(lambda: sim.row("ExposureTime").editor.field.text() == "1 s")
    assert sim.errors == []


def test_the_slider_follows_the_automatic_mode_and_taking_it_ends_that(sim):
    sim.grabber.start()
    row = sim.row("ExposureTime")
    sim.qtbot.waitUntil(lambda: row.auto is not None and row.auto.isEnabled())
    before = row.editor.field.text()
    row.auto.click()
    sim.qtbot.waitUntil(row.auto.isChecked)
    sim.qtbot.waitUntil(lambda: row.editor.field.text() != before)
    row.auto.click()
    sim.qtbot.waitUntil(lambda: not row.auto.isChecked())
    sim.qtbot.waitUntil(row.editor.isEnabled)
    row.editor.field.stepBy(1)
    assert sim.errors == []


def test_what_the_automatic_mode_alone_locks_can_be_moved_and_taken_back(sim):
    row = sim.row("ExposureTime")
    sim.qtbot.waitUntil(lambda: row.auto is not None and row.auto.isEnabled())
    row.auto.click()
    sim.qtbot.waitUntil(row.auto.isChecked)
    sim.qtbot.waitUntil(lambda: sim.model.feature("ExposureTime").access is AccessMode.READ_ONLY)
    sim.qtbot.waitUntil(lambda: row.editor.isEnabled() and row.editor.slider().isEnabled())
    sim.qtbot.keyClick(row.editor.slider(), Qt.Key_Home)
    sim.qtbot.waitUntil(lambda: sim.grabber.feature("ExposureAuto").value == "Off")
    sim.qtbot.waitUntil(lambda: not row.auto.isChecked())
    least = sim.grabber.feature("ExposureTime").minimum
    assert sim.grabber.feature("ExposureTime").value == least
    assert not sim.errors


def test_every_feature_of_the_simulated_camera_is_shown_and_none_written(sim, caplog, monkeypatch):
    writes = []
    monkeypatch.setattr(sim.grabber.device, "write", lambda *args: writes.append(args))
    sim.open_everything()
    assert sim.panel.watched == reachable(sim.model.root)
    assert [name for name in sim.panel.watched if sim.model.feature(name).problem] == []
    assert writes == []
    assert "cannot be shown" not in caplog.text


def vendor_descriptions():
    beside = Path(__file__).parents[3].parent / "shared" / "genicam-xml"
    folder = Path(os.environ.get("GRABBERGUI_GENICAM_XML", beside))
    found = sorted(folder.glob("*.xml"), key=lambda path: path.stat().st_size)
    return found if ALL else sorted({*found[:1], *found[-1:]})


@pytest.mark.parametrize(
    "path",
    vendor_descriptions() or [pytest.param(None, marks=pytest.mark.skip("no folder of vendors' XML"))],
    ids=lambda path: path.stem if path else "none",
)
def test_tour_of_a_vendors_camera(make_panel, path, caplog):
    """The panel of a real description opens in less than a second, and every section can be opened."""
    for watch in attempts(1.0, clock=time.process_time):
        device = XmlDevice(path.read_bytes())
        camera = DeviceGrabber(device)
        with watch:
            camera.open()
            d = make_panel(camera)
            d.filled()
    d.open_everything()
    assert d.panel.watched == reachable(d.model.root)
    assert device.writes == []
    assert not [r for r in caplog.records if r.levelno >= logging.ERROR]


def test_the_window_reads_no_register_in_its_own_thread(make_panel):
    """Texts of a gigabyte by the description: not even the attempt holds the window up."""
    texts = "".join(
        f'<StringReg Name="Text{number}"><Address>0</Address><Length>{1 << 30}</Length>'
        "<AccessMode>RW</AccessMode><pPort>Device</pPort></StringReg>"
        for number in range(60)
    )
    number = (
        '<IntReg Name="Number"><Address>0</Address><Length>4</Length><AccessMode>RW</AccessMode>'
        "<pPort>Device</pPort><Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>"
    )
    listed = "".join(f"<pFeature>Text{number}</pFeature>" for number in range(60))
    root = f'<Category Name="Root"><pFeature>Number</pFeature>{listed}</Category>'
    readers = []

    class Watched(XmlDevice):
        def read(self, address, length):
            readers.append(threading.current_thread())
            return super().read(address, length)

    camera = DeviceGrabber(Watched(f"{HEAD}{root}{number}{texts}</RegisterDescription>".encode()))
    camera.open()
    readers.clear()
    d = make_panel(camera)
    for watch in attempts(1.0, clock=time.process_time):
        with watch:
            d.open_everything()
    assert d.model.feature("Number").value == 0
    assert "1073741824 bytes" in d.model.feature("Text59").problem
    assert readers and threading.main_thread() not in readers

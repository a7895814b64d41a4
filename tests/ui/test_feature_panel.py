"""The panel and the favourites, joined by their controller to a model on a grabber."""

import itertools
import logging
import os
import struct
import time
from pathlib import Path

import pytest
from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QWidget

from fakes import ScriptedGrabber, XmlDevice
from grabbergui import sources
from grabbergui.core.errors import GrabberError
from grabbergui.core.features import AccessMode, Category, EnumEntry, Feature, FeatureKind, Visibility
from grabbergui.driver.camera import Camera
from grabbergui.models.features.tree import FeatureTreeModel
from grabbergui.models.features.worker import FeatureWorker
from grabbergui.ui.controllers.features import FeatureController
from grabbergui.ui.editors.feature_row import FeatureRow
from grabbergui.ui.views.favourites import FavouritesStrip
from grabbergui.ui.views.feature_panel import MOST_FOUND, FeaturePanel
from grabbergui.ui.widgets.section import Section

K, A = FeatureKind, AccessMode
MODES = tuple(EnumEntry(name) for name in ("Off", "Once", "Continuous"))


def feature(name, kind, value=None, category="AcquisitionControl", access=A.READ_WRITE, **more):
    return Feature(name=name, kind=kind, value=value, category=category, access=access, **more)


def camera_features():
    return [
        feature("DeviceUserID", K.STRING, "cam", "DeviceControl"),
        feature("Width", K.INTEGER, 640, "ImageFormatControl", minimum=16, maximum=2448, increment=16),
        feature("TriggerSelector", K.ENUMERATION, "FrameStart", entries=(EnumEntry("FrameStart"),)),
        feature("TriggerMode", K.ENUMERATION, "Off", entries=MODES[:1], selectors=("TriggerSelector",)),
        feature("TriggerSoftware", K.COMMAND, access=A.WRITE_ONLY),
        feature(
            "ExposureTime", K.FLOAT, 1e4, minimum=10.0, maximum=1e6, unit="us", auto="ExposureAuto",
            tooltip="How long the shutter is open.",
        ),
        feature("ExposureAuto", K.ENUMERATION, "Off", entries=MODES),
        feature("AcquisitionFrameRateAbs", K.FLOAT, 25.0, minimum=1.0, maximum=100.0),
        feature("Gain", K.FLOAT, 6.0, "AnalogControl", minimum=0.0, maximum=48.0),
        feature("BlackLevel", K.FLOAT, 1.0, "AnalogControl", visibility=Visibility.EXPERT),
        feature("Fuse", K.INTEGER, 1, "AnalogControl", visibility=Visibility.GURU),
    ]  # fmt: skip


class Desk:
    """Panel, strip and controller on a grabber."""

    def __init__(self, qtbot, grabber):
        self.qtbot = qtbot
        self.grabber = grabber
        self.panel, self.strip = FeaturePanel(), FavouritesStrip()
        for view in (self.panel, self.strip):
            qtbot.addWidget(view)
        self.panel.resize(340, 700)
        self.strip.resize(900, 80)
        self.controller = FeatureController(self.panel, self.strip)
        self.errors = []
        self.controller.failed.connect(self.errors.append)
        self.worker = FeatureWorker()
        self.model = FeatureTreeModel(grabber, self.worker)
        self.panel.show()
        self.strip.show()
        self.controller.set_model(self.model)

    def close(self):
        self.controller.set_model(None)
        self.model.close()
        self.worker.submit(self.grabber.close)
        assert self.worker.close()

    def row(self, name, view=None):
        """The row of a feature with its editor, waited for."""
        rows = (view or self.panel).rows

        def built():
            return bool(rows.rows(name)) and rows.rows(name)[0].editor is not None

        self.qtbot.waitUntil(built)
        return rows.rows(name)[0]

    def filled(self):
        """Wait until every row on show has its editor."""

        def full():
            rows = self.panel.rows
            return all(
                rows.rows(name) and all(row.editor is not None for row in rows.rows(name))
                for name in self.panel.watched
            )

        self.qtbot.waitUntil(full)

    def shown(self):
        self.filled()
        return [row.name for row in self.panel.findChildren(FeatureRow) if row.isVisible()]

    def open_everything(self):
        """Open each section, for gurus."""
        self.panel.levelBox.setCurrentText("Guru")
        while closed := [s for s in self.panel.findChildren(Section) if not (s.open or s.isHidden())]:
            for section in closed:
                section.header.click()
        self.filled()

    def written(self, name):
        return [value for written, value, _ in self.grabber.writes if written == name]


@pytest.fixture
def desk(qtbot):
    desks = []

    def build(grabber=None):
        desks.append(Desk(qtbot, grabber or ScriptedGrabber(camera_features())))
        return desks[-1]

    yield build
    for made in desks:
        made.close()


def test_without_a_camera_the_panel_says_so(qtbot):
    panel = FeaturePanel()
    qtbot.addWidget(panel)
    assert "connected" in panel.messageLabel.text()
    assert not panel.filterEdit.isEnabled()


def test_showing_every_feature_writes_none(desk):
    d = desk()
    d.panel.levelBox.setCurrentIndex(2)
    for section in d.panel.findChildren(Section):
        section.setOpen(True)
    d.panel.filterEdit.setText("e")
    d.panel.filterEdit.clear()
    assert set(d.shown()) == {f.name for f in camera_features()}
    for known in camera_features():
        d.grabber.features_changed.emit(frozenset([known.name]))
    d.grabber.set("Gain", 12.0)
    d.qtbot.waitUntil(lambda: d.row("Gain").editor.field.text() == "12")
    assert d.grabber.writes == []
    assert d.grabber.commands == []


def test_only_sections_that_are_open_are_built_and_read(desk):
    d = desk()
    d.filled()
    assert not d.panel.section("DeviceControl").open
    assert d.panel.rows.rows("DeviceUserID") == []
    assert "DeviceUserID" not in d.grabber.reads
    assert d.panel.section("AcquisitionControl").open
    d.qtbot.mouseClick(d.panel.section("DeviceControl").header, Qt.LeftButton)
    assert d.row("DeviceUserID").editor.line.text() == "cam"
    d.qtbot.mouseClick(d.panel.section("DeviceControl").header, Qt.LeftButton)
    assert not d.row("DeviceUserID").isVisible()
    reads = d.grabber.reads.count("DeviceUserID")
    d.grabber.set("DeviceUserID", "other")
    d.grabber.set("Gain", 1.0)
    d.qtbot.waitUntil(lambda: d.row("Gain").editor.field.text() == "1")
    assert d.grabber.reads.count("DeviceUserID") == reads


def test_rows_stand_in_the_cameras_order(desk):
    d = desk()
    d.filled()
    names = [row.name for row in d.panel.section("AcquisitionControl").findChildren(FeatureRow)]
    rows = sorted(names, key=lambda name: d.row(name).y())
    assert rows == [f.name for f in camera_features() if f.category == "AcquisitionControl"]


def test_a_selected_feature_stands_below_its_selector(desk):
    d = desk()
    selector, selected = d.row("TriggerSelector"), d.row("TriggerMode")
    assert selected.layout().contentsMargins().left() > selector.layout().contentsMargins().left()


def test_visibility_levels(desk):
    d = desk()
    assert "BlackLevel" not in d.shown()
    d.panel.levelBox.setCurrentText("Expert")
    assert "BlackLevel" in d.shown()
    assert "Fuse" not in d.shown()
    d.panel.levelBox.setCurrentText("Guru")
    assert "Fuse" in d.shown()
    d.panel.levelBox.setCurrentText("Beginner")
    assert not {"Fuse", "BlackLevel"} & set(d.shown())


def test_the_filter_finds_what_is_collapsed_and_hides_the_rest(desk):
    d = desk()
    d.filled()
    d.qtbot.keyClicks(d.panel.filterEdit, "userid")
    assert d.shown() == ["DeviceUserID"]
    assert d.panel.section("AnalogControl").isHidden()
    d.panel.filterEdit.setText("shutter")
    assert d.shown() == ["ExposureTime"]
    d.panel.filterEdit.setText("fuse")
    assert d.shown() == []
    assert d.panel.messageLabel.text() == "Guru shows 1 more."
    d.panel.filterEdit.setText("xyz")
    assert d.panel.messageLabel.text() == "Nothing matches."
    d.panel.filterEdit.clear()
    assert "DeviceUserID" not in d.shown()
    assert "Gain" in d.shown()


def test_dragging_a_slider_writes_at_most_every_50_ms_and_the_last_value(desk):
    d = desk()
    editor = d.row("Gain").editor
    slider = editor.slider()
    slider.setSliderDown(True)
    for position in range(0, 1000, 10):
        slider.setSliderPosition(position)
        d.qtbot.wait(2)
    last = editor.field.text()
    slider.setSliderDown(False)
    d.qtbot.waitUntil(lambda: d.grabber.known["Gain"].value == float(last))
    times = [moment for _, _, moment in d.grabber.writes]
    assert min(b - a for a, b in itertools.pairwise(times)) >= 0.049
    assert 2 <= len(times) < 100
    d.qtbot.waitUntil(lambda: d.row("Gain", d.strip).editor.field.text() == last)


def test_while_dragged_nothing_from_outside_moves_the_slider(desk):
    d = desk()
    slider = d.row("Gain").editor.slider()
    slider.setSliderDown(True)
    position = slider.value()
    d.grabber.set("Gain", 40.0)
    d.qtbot.waitUntil(lambda: d.model.feature("Gain").value == 40.0)
    d.qtbot.wait(30)
    assert slider.value() == position
    slider.setSliderDown(False)
    d.qtbot.waitUntil(lambda: d.row("Gain").editor.field.text() == "40")
    assert d.grabber.writes == []


def test_a_refused_write_is_told_and_the_widget_shows_the_truth(desk):
    d = desk()
    d.row("Gain")
    d.grabber.refusals["Gain"] = GrabberError("Gain=9: the camera answered: busy")
    d.row("Gain").editor.field.stepBy(30)
    assert d.row("Gain").editor.field.text() == "9"
    d.qtbot.waitUntil(lambda: bool(d.errors))
    assert d.errors == ["Gain=9: the camera answered: busy"]
    d.qtbot.waitUntil(lambda: d.row("Gain").editor.field.text() == "6")


def test_what_the_camera_made_of_a_value_is_shown(desk):
    d = desk()
    d.grabber.on_write = lambda name, value: 16.0
    d.row("Gain").editor.field.stepBy(90)
    d.qtbot.waitUntil(lambda: d.row("Gain").editor.field.text() == "16")


def test_the_auto_button_beside_a_control(desk):
    d = desk()
    row = d.row("ExposureTime")
    d.qtbot.waitUntil(lambda: row.auto is not None)
    row.auto.click()
    d.qtbot.waitUntil(lambda: d.written("ExposureAuto") == ["Continuous"])
    d.qtbot.waitUntil(row.auto.isChecked)
    d.qtbot.waitUntil(lambda: d.row("ExposureAuto").editor.combo.currentText() == "Continuous")
    assert d.row("ExposureTime", d.strip).auto.isChecked()
    # The camera regulates, and the slider follows.
    before = row.editor.slider().value()
    d.grabber.set("ExposureTime", 5e5)
    d.qtbot.waitUntil(lambda: row.editor.slider().value() > before)
    row.auto.click()
    d.qtbot.waitUntil(lambda: d.written("ExposureAuto") == ["Continuous", "Off"])


def test_a_feature_that_gets_locked_turns_grey_and_comes_back(desk):
    d = desk()
    row = d.row("Gain")
    d.grabber.set("Gain", access=A.READ_ONLY)
    d.qtbot.waitUntil(lambda: not row.editor.isEnabled())
    assert "read-only" in row.toolTip()
    d.grabber.set("Gain", access=A.READ_WRITE)
    d.qtbot.waitUntil(row.editor.isEnabled)


def test_a_command_is_run(desk):
    d = desk()
    d.qtbot.mouseClick(d.row("TriggerSoftware").editor.button, Qt.LeftButton)
    d.qtbot.waitUntil(lambda: d.grabber.commands == ["TriggerSoftware"])


def test_favourites_are_there_whatever_the_camera_calls_them(desk):
    d = desk()
    rows = [d.row(name, d.strip) for name in ("ExposureTime", "Gain", "AcquisitionFrameRateAbs")]
    assert [row.title for row in rows] == ["Exposure", "Gain", "Frame rate"]
    assert sorted(rows, key=QWidget.x) == rows
    rows[2].editor.field.stepBy(1)
    d.qtbot.waitUntil(lambda: d.written("AcquisitionFrameRateAbs") == [25.1])
    d.qtbot.waitUntil(lambda: d.row("AcquisitionFrameRateAbs").editor.field.text() == "25.1")


def test_a_favourite_of_a_closed_section_is_followed_too(desk):
    d = desk()
    d.qtbot.mouseClick(d.panel.section("AnalogControl").header, Qt.LeftButton)
    assert "Gain" not in d.panel.watched
    d.grabber.set("Gain", 33.0)
    d.qtbot.waitUntil(lambda: d.row("Gain", d.strip).editor.field.text() == "33")


def test_another_camera_replaces_the_first(desk):
    d = desk()
    d.filled()
    other = ScriptedGrabber([feature("GainRaw", K.INTEGER, 3, "Analog", minimum=0, maximum=10)])
    worker = FeatureWorker()
    model = FeatureTreeModel(other, worker)
    d.controller.set_model(model)
    assert d.row("GainRaw").editor.field.text() == "3"
    assert d.shown() == ["GainRaw"]
    d.grabber.set("Gain", 1.0)
    d.row("GainRaw").editor.field.stepBy(1)
    d.qtbot.waitUntil(lambda: other.known["GainRaw"].value == 4)
    d.controller.set_model(None)
    assert d.shown() == []
    assert d.strip.hintLabel.isVisible()
    model.close()
    assert worker.close()


def test_a_camera_that_changes_its_tree_is_shown_anew(desk):
    d = desk()
    d.filled()
    gamma = feature("Gamma", K.FLOAT, 1.0, "Fresh", minimum=0.1, maximum=4.0)
    d.grabber.known, d.grabber.tree = {"Gamma": gamma}, Category("Root", members=(gamma,))
    d.model.reload()
    d.qtbot.waitUntil(lambda: d.panel.watched == {"Gamma"})
    assert d.shown() == ["Gamma"]
    assert d.strip.hintLabel.isVisible()


def test_a_row_that_fails_leaves_the_others(desk, caplog):
    grabber = ScriptedGrabber(camera_features())
    grabber.failures["TriggerMode"] = RuntimeError("odd node")
    d = desk(grabber)
    d.filled()
    assert not d.row("TriggerMode").editor.isEnabled()
    assert "odd node" in d.row("TriggerMode").toolTip()
    assert d.row("ExposureTime").editor.isEnabled()


# -- many features -----------------------------------------------------------------------------------
def huge_grabber(count=3500, per_category=500):
    features = [
        feature(f"Feature{n}", K.FLOAT, 1.0, f"Category{n // per_category}", minimum=0.0, maximum=9.0)
        for n in range(count)
    ]
    return ScriptedGrabber(features)


def test_thousands_of_features_open_at_once_and_never_hold_the_event_loop(desk, qapp):
    # In seconds of this thread's own work: how busy the machine is otherwise must not matter.
    grabber = huge_grabber()
    start = time.thread_time()
    d = desk(grabber)
    worst = 0.0
    assert time.thread_time() - start < 0.5
    d.panel.section("Category3").header.click()
    deadline = time.monotonic() + 20
    while len(grabber.reads) < 1000 or any(
        not row.editor for name in d.panel.watched for row in d.panel.rows.rows(name)
    ):
        assert time.monotonic() < deadline
        turn = time.thread_time()
        qapp.processEvents()
        worst = max(worst, time.thread_time() - turn)
    assert worst < 0.1
    # Two sections were opened, nothing else was read.
    assert len(set(grabber.reads)) == 1000


def test_a_search_shows_so_many_and_says_how_many_more(desk):
    d = desk(huge_grabber())
    d.panel.filterEdit.setText("feature")
    assert len(d.panel.watched) == MOST_FOUND
    assert d.panel.messageLabel.text() == "3300 more match; type another letter."
    d.panel.filterEdit.setText("feature3499")
    assert d.shown() == ["Feature3499"]


# -- the simulated camera ----------------------------------------------------------------------------
EXPOSURE_REGISTER = 0x100330
"""Of the simulated camera: microseconds, a big-endian double."""


@pytest.fixture
def sim(desk):
    camera = sources.create("sim:?width=64&height=64")
    camera.open()
    return desk(camera)


def exposure_register(d):
    return struct.unpack(">d", d.grabber.device.read(EXPOSURE_REGISTER, 8))[0]


def test_a_slider_moves_the_cameras_register(sim):
    slider = sim.row("ExposureTime", sim.strip).editor.slider()
    sim.qtbot.mousePress(slider, Qt.LeftButton, pos=slider.rect().center())
    slider.setSliderPosition(slider.maximum())
    sim.qtbot.mouseRelease(slider, Qt.LeftButton, pos=slider.rect().center())
    sim.qtbot.waitUntil(lambda: exposure_register(sim) == 1e6)
    sim.qtbot.waitUntil(lambda: sim.row("ExposureTime").editor.field.text() == "1000000 µs")
    assert sim.errors == []


def test_the_slider_follows_the_automatic_mode_and_taking_it_ends_that(sim):
    sim.grabber.start()
    row = sim.row("ExposureTime")
    sim.qtbot.waitUntil(lambda: row.auto is not None)
    before = row.editor.field.text()
    row.auto.click()
    sim.qtbot.waitUntil(row.auto.isChecked)
    sim.qtbot.waitUntil(lambda: row.editor.field.text() != before)
    row.auto.click()
    sim.qtbot.waitUntil(lambda: not row.auto.isChecked())
    sim.qtbot.waitUntil(row.editor.isEnabled)
    row.editor.field.stepBy(1)
    assert sim.errors == []


def test_every_feature_of_the_simulated_camera_is_shown_and_none_written(sim, caplog, monkeypatch):
    writes = []
    monkeypatch.setattr(sim.grabber.device, "write", lambda *args: writes.append(args))
    sim.open_everything()
    assert sim.panel.watched == _reachable(sim.model.root)
    assert [name for name in sim.panel.watched if sim.model.feature(name).problem] == []
    assert writes == []
    assert "cannot be shown" not in caplog.text


# -- real cameras' descriptions ----------------------------------------------------------------------
def vendor_descriptions():
    beside = Path(__file__).parents[2].parent / "shared" / "genicam-xml"
    folder = Path(os.environ.get("GRABBERGUI_GENICAM_XML", beside))
    return sorted(folder.glob("*.xml"))


@pytest.mark.parametrize(
    "path",
    vendor_descriptions() or [pytest.param(None, marks=pytest.mark.skip("no folder of vendors' XML"))],
    ids=lambda path: path.stem if path else "none",
)
def test_tour_of_a_vendors_camera(desk, path, caplog):
    """The panel of a real description opens in less than a second, and every section can be opened."""
    device = XmlDevice(path.read_bytes())
    camera = Camera(device)
    start = time.process_time()
    camera.open()
    d = desk(camera)
    d.filled()
    assert time.process_time() - start < 1.0
    d.open_everything()
    assert d.panel.watched == _reachable(d.model.root)
    assert device.writes == []
    assert not [r for r in caplog.records if r.levelno >= logging.ERROR]


def _reachable(category: Category) -> set[str]:
    names: set[str] = set()
    for member in category.members:
        if member.visibility <= Visibility.GURU:
            names |= _reachable(member) if isinstance(member, Category) else {member.name}
    return names


def test_what_the_automatic_mode_alone_locks_can_be_moved_and_taken_back(sim):
    row = sim.row("ExposureTime")
    sim.qtbot.waitUntil(lambda: row.auto is not None)
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


def test_other_locks_stay_however_the_automatic_mode_is(desk):
    d = desk()
    row = d.row("ExposureTime")
    d.grabber.set("ExposureTime", access=AccessMode.READ_ONLY)
    d.qtbot.waitUntil(lambda: not row.editor.isEnabled())
    d.grabber.set("ExposureAuto", "Continuous", access=AccessMode.READ_ONLY)
    d.qtbot.waitUntil(lambda: row.auto is not None and row.auto.isChecked())
    assert not row.editor.isEnabled() and not row.editor.slider().isEnabled()

"""The feature panel shows sections, levels and search results, however many features there are."""

import time
from itertools import combinations

from PyQt5.QtCore import QPoint, Qt
from PyQt5.QtWidgets import QLabel, QMenu, QWidget

from fakes import ScriptedGrabber
from grabbergui.core.features import Category
from grabbergui.models.features.tree import FeatureTreeModel
from grabbergui.models.features.worker import FeatureWorker
from grabbergui.ui.editors.feature_row import FeatureRow
from grabbergui.ui.gui_thread import Pacer
from grabbergui.ui.views.feature_panel import MOST_FOUND, FeaturePanel, Section
from panel_harness import K, camera_features, feature
from patience import PATIENCE, allowance, attempts, little_garbage


def test_without_a_camera_the_panel_reports_it(qtbot):
    panel = FeaturePanel()
    qtbot.addWidget(panel)
    assert "connected" in panel.messageLabel.text()
    assert not panel.filterEdit.isEnabled()


def test_showing_every_feature_writes_none(make_panel):
    d = make_panel()
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


def test_only_sections_that_are_open_are_built_and_read(make_panel):
    d = make_panel()
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


def test_rows_stand_in_the_cameras_order(make_panel):
    d = make_panel()
    d.filled()
    names = [row.name for row in d.panel.section("AcquisitionControl").findChildren(FeatureRow)]
    rows = sorted(names, key=lambda name: d.row(name).y())
    assert rows == [f.name for f in camera_features() if f.category == "AcquisitionControl"]


def test_a_selected_feature_is_shown_below_its_selector(make_panel):
    d = make_panel()
    selector, selected = d.row("TriggerSelector"), d.row("TriggerMode")
    names = [row.findChild(QLabel) for row in (selected, selector)]
    assert names[0].contentsRect().left() > names[1].contentsRect().left()
    editors = [row.editor.mapTo(row, QPoint()).x() for row in (selected, selector)]
    assert editors[0] == editors[1]  # what is typed into stays in its column


def test_visibility_levels(make_panel):
    d = make_panel()
    d.panel.levelBox.setCurrentText("Beginner")
    assert "BlackLevel" not in d.shown()
    d.panel.levelBox.setCurrentText("Expert")
    assert "BlackLevel" in d.shown()
    assert "Fuse" not in d.shown()
    d.panel.levelBox.setCurrentText("Guru")
    assert "Fuse" in d.shown()
    d.panel.levelBox.setCurrentText("Beginner")
    assert not {"Fuse", "BlackLevel"} & set(d.shown())


def test_beginners_see_a_pinned_feature_once(make_panel):
    d = make_panel()
    d.panel.levelBox.setCurrentText("Beginner")
    pinned = {"ExposureTime", "ExposureAuto", "Gain", "AcquisitionFrameRateAbs"}
    assert {"ExposureTime", "Gain"} <= {row.name for row in d.strip.findChildren(FeatureRow)}
    assert "TriggerMode" in d.shown() and not pinned & set(d.shown())
    d.controller.show_favourites(("Gain",))  # the others were unpinned
    d.qtbot.waitUntil(lambda: "ExposureTime" in d.panel.watched)
    assert pinned - {"Gain"} <= set(d.shown()) and "Gain" not in d.shown()
    d.panel.filterEdit.setText("gain")
    assert d.shown() == ["Gain"], "who searches for it finds it"
    d.panel.filterEdit.clear()
    d.panel.levelBox.setCurrentText("Expert")
    assert pinned <= set(d.shown())


def test_the_filter_finds_what_is_collapsed_and_hides_the_rest(make_panel):
    d = make_panel()
    d.filled()
    d.qtbot.keyClicks(d.panel.filterEdit, "userid")
    assert d.shown() == ["DeviceUserID"]
    assert d.panel.section("AnalogControl").isHidden()
    d.panel.filterEdit.setText("shutter")
    assert d.shown() == ["ExposureTime"]
    d.panel.filterEdit.setText("fuse")
    assert d.shown() == []
    assert d.panel.moreButton.text() == "Show 1 more (Guru)"
    level = d.panel.levelBox.currentIndex()
    d.panel.moreButton.click()
    assert d.shown() != [] and d.panel.moreButton.isHidden()
    d.panel.levelBox.setCurrentIndex(level)
    d.panel.filterEdit.setText("xyz")
    assert d.panel.messageLabel.text() == "Nothing matches."
    d.panel.filterEdit.clear()
    assert "DeviceUserID" not in d.shown()
    assert "Gain" in d.shown()


def test_another_camera_replaces_the_first(make_panel):
    d = make_panel()
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


def test_a_changed_feature_tree_is_shown_again(make_panel):
    d = make_panel()
    d.filled()
    gamma = feature("Gamma", K.FLOAT, 1.0, "Fresh", minimum=0.1, maximum=4.0)
    d.grabber.known, d.grabber.tree = {"Gamma": gamma}, Category("Root", members=(gamma,))
    d.model.reload()
    d.qtbot.waitUntil(lambda: d.panel.watched == {"Gamma"})
    assert d.shown() == ["Gamma"]
    assert d.strip.hintLabel.isVisible()


def test_a_row_that_fails_leaves_the_others(make_panel, caplog):
    grabber = ScriptedGrabber(camera_features())
    grabber.failures["TriggerMode"] = RuntimeError("odd node")
    d = make_panel(grabber)
    d.filled()
    assert not d.row("TriggerMode").editor.isEnabled()
    assert "odd node" in d.row("TriggerMode").toolTip()
    assert d.row("ExposureTime").editor.isEnabled()


def huge_grabber(count=3500, per_category=500):
    features = [
        feature(f"Feature{n}", K.FLOAT, 1.0, f"Category{n // per_category}", minimum=0.0, maximum=9.0)
        for n in range(count)
    ]
    return ScriptedGrabber(features)


def test_thousands_of_features_open_at_once_and_never_hold_the_event_loop(make_panel, qapp):
    # In seconds of this thread's own work: how busy the machine is otherwise must not matter.
    for watch in attempts(0.5, clock=time.thread_time):
        grabber = huge_grabber()
        with watch:
            d = make_panel(grabber)
    worst = 0.0
    d.panel.section("Category3").header.click()
    deadline = time.monotonic() + PATIENCE
    with little_garbage():
        while len(grabber.reads) < 1000 or any(
            not row.editor for name in d.panel.watched for row in d.panel.rows.rows(name)
        ):
            assert time.monotonic() < deadline
            turn = time.thread_time()
            qapp.processEvents()
            worst = max(worst, time.thread_time() - turn)
    assert worst < 0.1 * allowance()
    # Two sections were opened, nothing else was read.
    assert len(set(grabber.reads)) == 1000


def test_a_search_shows_so_many_and_says_how_many_more(make_panel):
    d = make_panel(huge_grabber())
    d.panel.filterEdit.setText("feature")
    assert len(d.panel.watched) == MOST_FOUND
    assert d.panel.messageLabel.text() == "3300 more match; type another letter."
    d.panel.filterEdit.setText("feature3499")
    assert d.shown() == ["Feature3499"]


def test_escape_in_the_filter_shows_everything_again(make_panel, qtbot):
    d = make_panel()
    d.panel.filterEdit.setText("gain")
    assert "ExposureTime" not in d.shown()
    qtbot.keyClick(d.panel.filterEdit, Qt.Key_Escape)
    assert d.panel.filterEdit.text() == ""
    assert "ExposureTime" in d.shown()


def seen_over_each_other(widget):
    """Pairs of rows and sections below a widget that are painted over each other, as things stand now."""
    found = []
    for parent in [widget, *widget.findChildren(QWidget)]:
        children = [c for c in parent.children() if isinstance(c, (FeatureRow, Section)) and c.isVisible()]
        for one, other in combinations(children, 2):
            if not (one.geometry() & other.geometry() & parent.rect()).isEmpty():
                found.append((one, other))
    return found


def test_rows_that_have_no_place_yet_are_not_painted_over_each_other(make_panel):
    d = make_panel()
    d.filled()
    tree = d.model.root
    d.panel.setTree(None)
    d.panel.setTree(tree, [description.name for description in tree.descriptions()])
    d.strip.setFavourites(list(tree.descriptions())[:3])
    pacer = d.panel.findChild(Pacer)
    while not pacer.idle:
        pacer.run_turn()  # a window may be painted before it is laid out
    assert len(d.panel.findChildren(FeatureRow)) > 3
    assert not seen_over_each_other(d.panel) and not seen_over_each_other(d.strip)


def test_all_sections_are_opened_and_closed_at_once(make_panel):
    d = make_panel()
    sections = d.panel.findChild(Section)
    first = next(iter(sections.findChildren(Section)))

    def choose(text):
        first.header.customContextMenuRequested.emit(QPoint(5, 5))
        menu = first.findChildren(QMenu)[-1]
        next(action for action in menu.actions() if action.text() == text).trigger()
        menu.close()

    choose("Expand all")
    opened = [section for section in sections.findChildren(Section) if section.isVisibleTo(d.panel)]
    assert opened and all(section.open for section in opened)
    choose("Collapse all")
    assert not any(section.open for section in sections.findChildren(Section))
    assert d.panel.watched == frozenset()

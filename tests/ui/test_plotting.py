"""Values over time, plotted as a person asks for it."""

import csv
from itertools import pairwise

import pytest
from feature_menus import choose_from_menu, menu_of
from PyQt5.QtCore import QPoint, Qt
from PyQt5.QtWidgets import QApplication

from grabbergui.core.errors import DeviceLostError
from grabbergui.models.features import value_watch
from grabbergui.models.features.value_watch import MOST_FEATURES
from grabbergui.models.open_source import LinkState


@pytest.fixture
def desk(window_desk):
    window_desk.connect("sim:?width=320&height=240&fps=60")
    return window_desk


def label_of(desk, name):
    """What a feature is called in the strip of favourites."""
    rows = desk.window.favourites.rows
    desk.until(lambda: rows.rows(name) and rows.rows(name)[0].editor is not None)
    return rows.rows(name)[0]._label


def choose(desk, name, text):
    choose_from_menu(desk, label_of(desk, name), text)


def curve(desk, name):
    values = desk.window.values.row(name).plot.values(name)
    return [] if values is None else values[values == values].tolist()


def beginnings_of_lines(desk, name):
    """How many separate lines are drawn for a curve."""
    path = desk.window.values.row(name).plot._lines[name].curve.getPath()
    elements = [path.elementAt(index) for index in range(path.elementCount())]
    return sum(here.isMoveTo() and after.isLineTo() for here, after in pairwise(elements))


def test_a_feature_is_plotted_from_its_menu_and_follows_the_camera(desk):
    choose(desk, "Gain", "Plot over time")
    assert desk.window.valuesDock.isVisible()
    desk.until(lambda: len(curve(desk, "Gain")) >= 3)
    desk.grabber.write_feature("Gain", 6.0)
    desk.until(lambda: curve(desk, "Gain")[-1] == 6.0)
    assert curve(desk, "Gain")[0] == 0.0
    row = desk.window.values.row("Gain")
    assert (row.valueLabel.text(), row.rangeLabel.text()) == ("6 dB", "0 … 6")
    desk.qtbot.mouseClick(row.removeButton, Qt.LeftButton)
    assert desk.window.values.row("Gain") is None
    assert desk.window.values.hintLabel.isVisible()
    assert desk.program.values.names == ()


def test_value_range_and_axis_have_the_unit_that_the_value_needs(desk):
    desk.grabber.write_feature("ExposureTime", 10_000.0)
    choose(desk, "ExposureTime", "Plot over time")
    row = desk.window.values.row("ExposureTime")
    desk.until(lambda: row.valueLabel.text() == "10 ms")
    assert row.rangeLabel.text() == "10 … 10"
    assert row.plot.getAxis("left").scale == 1e-3


def test_pausing_hiding_and_clearing(desk):
    choose(desk, "Gain", "Plot over time")
    choose(desk, "ExposureTime", "Plot over time")
    desk.until(lambda: len(curve(desk, "Gain")) >= 2 and len(curve(desk, "ExposureTime")) >= 2)
    panel = desk.window.values
    desk.qtbot.mouseClick(panel.pauseButton, Qt.LeftButton)
    assert not desk.program.values._watch._wanted
    desk.watch(5)
    kept = len(curve(desk, "Gain"))
    desk.watch(10)
    assert len(curve(desk, "Gain")) == kept
    desk.qtbot.mouseClick(panel.pauseButton, Qt.LeftButton)
    desk.until(lambda: len(curve(desk, "Gain")) > kept)
    desk.qtbot.mouseClick(panel.clearButton, Qt.LeftButton)
    assert len(curve(desk, "Gain")) == 0
    desk.until(lambda: len(curve(desk, "Gain")) >= 1)
    desk.window.valuesDock.hide()
    desk.until(lambda: not desk.program.values._watch._wanted)


def test_values_are_saved_as_a_table(desk, tmp_path):
    choose(desk, "Gain", "Plot over time")
    desk.until(lambda: len(curve(desk, "Gain")) >= 3)
    path = tmp_path / "values.csv"
    desk.program.values.save(path)
    rows = list(csv.reader(path.read_text().splitlines()))
    assert rows[0] == ["time", "Gain"] and len(rows) >= 4
    assert rows[1][0].endswith("+00:00") and rows[1][1] == "0.0"
    desk.program.values.save(tmp_path / "no" / "folder.csv")
    desk.until(lambda: any("could not be written" in text for text in desk.errors))


def test_another_camera_takes_the_curves_over(desk):
    choose(desk, "Gain", "Plot over time")
    desk.until(lambda: len(curve(desk, "Gain")) >= 2)
    desk.program.connection.disconnect()
    desk.connect("sim:?width=64&height=64&gain=3")
    desk.until(lambda: curve(desk, "Gain")[-2:] == [3.0, 3.0])
    assert beginnings_of_lines(desk, "Gain") == 2, "no line leads from one camera's value to the other's"


def test_curves_break_where_another_open_camera_is_made_the_current_one(desk):
    choose(desk, "Gain", "Plot over time")
    desk.until(lambda: len(curve(desk, "Gain")) >= 2)
    first = desk.program.connection.source
    desk.program.connection.open_additional("sim:colour?width=64&height=64&gain=3")
    desk.until(lambda: len(desk.program.connection.sources) == 2)
    second = desk.program.connection.sources[1]
    desk.until(lambda: second.state is LinkState.STREAMING)
    for source, gain, lines in ((second, 3.0, 2), (first, 0.0, 3)):
        desk.program.connection.make_current(source)
        desk.until(lambda gain=gain: curve(desk, "Gain")[-2:] == [gain, gain])
        assert beginnings_of_lines(desk, "Gain") == lines


def test_curves_break_while_the_camera_does_not_answer(desk, monkeypatch):
    choose(desk, "Gain", "Plot over time")
    desk.until(lambda: len(curve(desk, "Gain")) >= 2)
    monkeypatch.setattr(value_watch, "PATIENCE", 0.02)
    read = desk.grabber.feature

    def silent(name):
        raise DeviceLostError("the camera does not answer")

    row = desk.window.values.row("Gain")
    desk.grabber.feature = silent
    desk.until(lambda: row.plot.values("Gain")[-1] != row.plot.values("Gain")[-1])
    assert row.valueLabel.text() in ("", "–"), "no value of now is claimed"
    before = len(curve(desk, "Gain"))
    desk.grabber.feature = read
    desk.until(lambda: len(curve(desk, "Gain")) >= before + 2)
    assert beginnings_of_lines(desk, "Gain") == 2


def test_too_many_curves_are_refused_in_words(desk):
    source = desk.program.connection.source
    numbers = [d for d in source.features.root.descriptions() if d.kind.value in ("integer", "float")]
    for description in numbers[: MOST_FEATURES + 1]:
        desk.program.values.plot(description)
    assert len(desk.program.values.names) == MOST_FEATURES
    assert "no more than 12" in desk.errors[0]


def test_name_and_value_are_copied(desk):
    choose(desk, "Gain", "Copy the name")
    assert QApplication.clipboard().text() == "Gain"
    choose(desk, "ExposureTime", "Copy name and value")
    assert QApplication.clipboard().text() == "ExposureTime=10000"


def test_what_is_no_number_cannot_be_plotted(desk):
    menu = menu_of(desk, label_of(desk, "Gain"))
    assert "Plot over time" in [a.text().replace("&", "") for a in menu.actions()]
    menu.close()
    desk.until(lambda: desk.program.feature_menu.menu is None)
    desk.program.feature_menu._on_menu_requested("PixelFormat", QPoint())
    menu = desk.program.feature_menu.menu
    assert "Plot over time" not in [a.text().replace("&", "") for a in menu.actions()]
    menu.close()


def test_two_curves_are_laid_over_each_other_each_over_its_own_range(desk):
    panel = desk.window.values
    for name in ("Gain", "ExposureTime"):
        choose(desk, name, "Plot over time")
        desk.until(lambda name=name: len(curve(desk, name)) >= 2)
    desk.grabber.write_feature("Gain", 6.0)
    desk.until(lambda: curve(desk, "Gain")[-1] == 6.0)
    panel.togetherBox.click()
    assert panel.overlay.isVisible() and not panel.row("Gain").plot.isVisible()
    desk.until(lambda: panel.overlay.values("Gain") is not None)
    gain = panel.overlay.values("Gain")
    assert (gain[0], gain[-1]) == (0.0, 1.0), "from 0 to 6 dB"
    assert panel.overlay.values("ExposureTime")[0] == 0.5, "it did not change"
    colours = {panel.row(name).titleLabel.styleSheet() for name in ("Gain", "ExposureTime")}
    assert len(colours) == 2
    desk.qtbot.mouseClick(panel.row("Gain").removeButton, Qt.LeftButton)
    assert panel.overlay.values("Gain") is None
    panel.togetherBox.click()
    assert not panel.overlay.isVisible() and panel.row("ExposureTime").plot.isVisible()

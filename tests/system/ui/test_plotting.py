"""Values over time, plotted as a person asks for it."""

import csv
from itertools import pairwise

import pytest
from PyQt5.QtCore import QPoint, Qt
from PyQt5.QtWidgets import QApplication

from feature_menus import choose_from_menu, menu_of
from grabbergui.core.errors import DeviceLostError
from grabbergui.models.features import value_history
from grabbergui.models.features.value_history import MOST_WATCHED
from grabbergui.models.open_source import LinkState


@pytest.fixture
def app(make_app):
    app = make_app()
    app.connect("sim:?width=320&height=240&fps=15")
    return app


def label_of(app, name):
    """Return a feature's name in the strip of pinned controls."""
    rows = app.window.favourites.rows
    app.until(lambda: rows.rows(name) and rows.rows(name)[0].editor is not None)
    return rows.rows(name)[0]._label


def choose(app, name, text):
    choose_from_menu(app, label_of(app, name), text)


def curve(app, name):
    values = app.window.values.row(name).plot.values(name)
    return [] if values is None else values[values == values].tolist()


def beginnings_of_lines(app, name):
    """How many separate lines are drawn for a curve."""
    path = app.window.values.row(name).plot._lines[name].curve.getPath()
    elements = [path.elementAt(index) for index in range(path.elementCount())]
    return sum(here.isMoveTo() and after.isLineTo() for here, after in pairwise(elements))


def test_a_feature_is_plotted_from_its_menu_and_follows_the_camera(app):
    choose(app, "Gain", "Plot over time")
    assert app.window.valuesDock.isVisible()
    app.until(lambda: len(curve(app, "Gain")) >= 3)
    app.grabber.write_feature("Gain", 6.0)
    app.until(lambda: curve(app, "Gain")[-1] == 6.0)
    assert curve(app, "Gain")[0] == 0.0
    row = app.window.values.row("Gain")
    assert (row.valueLabel.text(), row.rangeLabel.text()) == ("6 dB", "0 … 6")
    app.qtbot.mouseClick(row.removeButton, Qt.LeftButton)
    assert app.window.values.row("Gain") is None
    assert app.window.values.hintLabel.isVisible()
    assert app.program.feature_controls.values.names == ()


def test_value_range_and_axis_have_the_unit_that_the_value_needs(app):
    app.grabber.write_feature("ExposureTime", 10_000.0)
    choose(app, "ExposureTime", "Plot over time")
    row = app.window.values.row("ExposureTime")
    app.until(lambda: row.valueLabel.text() == "10 ms")
    assert row.rangeLabel.text() == "10 … 10"
    assert row.plot.getAxis("left").scale == 1e-3


def test_pausing_hiding_and_clearing(app):
    choose(app, "Gain", "Plot over time")
    choose(app, "ExposureTime", "Plot over time")
    app.until(lambda: len(curve(app, "Gain")) >= 2 and len(curve(app, "ExposureTime")) >= 2)
    panel = app.window.values
    app.qtbot.mouseClick(panel.pauseButton, Qt.LeftButton)
    assert not app.program.feature_controls.values._watch._wanted
    app.watch(5)
    kept = len(curve(app, "Gain"))
    app.watch(10)
    assert len(curve(app, "Gain")) == kept
    app.qtbot.mouseClick(panel.pauseButton, Qt.LeftButton)
    app.until(lambda: len(curve(app, "Gain")) > kept)
    app.qtbot.mouseClick(panel.clearButton, Qt.LeftButton)
    assert len(curve(app, "Gain")) == 0
    app.until(lambda: len(curve(app, "Gain")) >= 1)
    app.window.valuesDock.hide()
    app.until(lambda: not app.program.feature_controls.values._watch._wanted)


def test_values_are_saved_as_a_table(app, tmp_path):
    choose(app, "Gain", "Plot over time")
    app.until(lambda: len(curve(app, "Gain")) >= 3)
    path = tmp_path / "values.csv"
    app.program.feature_controls.values.save(path)
    rows = list(csv.reader(path.read_text().splitlines()))
    assert rows[0] == ["time", "Gain"] and len(rows) >= 4
    assert rows[1][0].endswith("+00:00") and rows[1][1] == "0.0"
    app.program.feature_controls.values.save(tmp_path / "no" / "folder.csv")
    app.until(lambda: any("could not be written" in text for text in app.errors))


def test_another_camera_takes_the_curves_over(app):
    choose(app, "Gain", "Plot over time")
    app.until(lambda: len(curve(app, "Gain")) >= 2)
    app.program.open_sources.close_current()
    app.connect("sim:?width=64&height=64&gain=3")
    app.until(lambda: curve(app, "Gain")[-2:] == [3.0, 3.0])
    assert beginnings_of_lines(app, "Gain") == 2, "no line leads from one camera's value to the other's"


def test_curves_break_where_another_open_camera_is_made_the_current_one(app):
    choose(app, "Gain", "Plot over time")
    app.until(lambda: len(curve(app, "Gain")) >= 2)
    first = app.program.open_sources.current
    app.program.opener.open_additional("sim:colour?width=64&height=64&gain=3")
    app.until(lambda: len(app.program.open_sources.all) == 2)
    second = app.program.open_sources.all[1]
    app.until(lambda: second.state is LinkState.STREAMING)
    for source, gain, lines in ((second, 3.0, 2), (first, 0.0, 3)):
        app.program.open_sources.make_current(source)
        app.until(lambda gain=gain: curve(app, "Gain")[-2:] == [gain, gain])
        assert beginnings_of_lines(app, "Gain") == lines


def test_curves_break_while_the_camera_does_not_answer(app, monkeypatch):
    choose(app, "Gain", "Plot over time")
    app.until(lambda: len(curve(app, "Gain")) >= 2)
    monkeypatch.setattr(value_history, "RETRY_PERIOD", 0.02)
    read = app.grabber.feature

    def silent(name):
        raise DeviceLostError("the camera does not answer")

    row = app.window.values.row("Gain")
    app.grabber.feature = silent
    app.until(lambda: row.plot.values("Gain")[-1] != row.plot.values("Gain")[-1])
    assert row.valueLabel.text() in ("", "–"), "no value of now is claimed"
    before = len(curve(app, "Gain"))
    app.grabber.feature = read
    app.until(lambda: len(curve(app, "Gain")) >= before + 2)
    assert beginnings_of_lines(app, "Gain") == 2


def test_too_many_curves_are_refused_in_words(app):
    source = app.program.open_sources.current
    numbers = [d for d in source.features.root.descriptions() if d.kind.value in ("integer", "float")]
    for description in numbers[: MOST_WATCHED + 1]:
        app.program.feature_controls.values.plot(description)
    assert len(app.program.feature_controls.values.names) == MOST_WATCHED
    assert "no more than 12" in app.errors[0]


def test_name_and_value_are_copied(app):
    choose(app, "Gain", "Copy the name")
    assert QApplication.clipboard().text() == "Gain"
    choose(app, "ExposureTime", "Copy name and value")
    assert QApplication.clipboard().text() == "ExposureTime=10000"


def test_what_is_no_number_cannot_be_plotted(app):
    menu = menu_of(app, label_of(app, "Gain"))
    assert "Plot over time" in [a.text().replace("&", "") for a in menu.actions()]
    menu.close()
    app.until(lambda: app.program.feature_controls.feature_menu.menu is None)
    app.program.feature_controls.feature_menu._on_menu_requested("PixelFormat", QPoint())
    menu = app.program.feature_controls.feature_menu.menu
    assert "Plot over time" not in [a.text().replace("&", "") for a in menu.actions()]
    menu.close()


def test_two_curves_are_laid_over_each_other_each_over_its_own_range(app):
    panel = app.window.values
    for name in ("Gain", "ExposureTime"):
        choose(app, name, "Plot over time")
        app.until(lambda name=name: len(curve(app, name)) >= 2)
    app.grabber.write_feature("Gain", 6.0)
    app.until(lambda: curve(app, "Gain")[-1] == 6.0)
    panel.togetherBox.click()
    assert panel.overlay.isVisible() and not panel.row("Gain").plot.isVisible()
    app.until(lambda: panel.overlay.values("Gain") is not None)
    gain = panel.overlay.values("Gain")
    assert (gain[0], gain[-1]) == (0.0, 1.0), "from 0 to 6 dB"
    assert panel.overlay.values("ExposureTime")[0] == 0.5, "it did not change"
    colours = {panel.row(name).titleLabel.styleSheet() for name in ("Gain", "ExposureTime")}
    assert len(colours) == 2
    app.qtbot.mouseClick(panel.row("Gain").removeButton, Qt.LeftButton)
    assert panel.overlay.values("Gain") is None
    panel.togetherBox.click()
    assert not panel.overlay.isVisible() and panel.row("ExposureTime").plot.isVisible()

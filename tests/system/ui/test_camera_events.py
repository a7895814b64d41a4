"""The camera's events in the window: switched, listed, marked on the curves."""

from PyQt5.QtCore import Qt
from PyQt5.QtGui import QGuiApplication

from grabbergui.core.settings import SettingKey
from grabbergui.ui.widgets.plots import MOST_MARKS, ChannelPlot

TEST = SettingKey("EventNotification", (("EventSelector", "Test"),))


def test_an_event_is_ticked_listed_and_marked_on_the_curves(make_app):
    app = make_app()
    app.connect("sim:?fps=15&width=64&height=48")
    app.until(app.window.actionEvents.isEnabled)
    app.window.actionEvents.trigger()
    controls = app.program.feature_controls
    dialog = controls.events.dialog
    app.until(lambda: dialog.switchList.count() > 4)
    (item,) = dialog.switchList.findItems("Test", Qt.MatchExactly)
    dialog.switchList.setCurrentItem(item)
    app.qtbot.keyClick(dialog.switchList, Qt.Key_Space)
    app.until(lambda: app.grabber.read_setting(TEST).value == "On")
    controls.values.plot(app.program.open_sources.current.features.description("ExposureTime"))
    app.grabber.execute("TestEventGenerate")
    app.until(lambda: dialog.table.topLevelItemCount() == 1)
    row = dialog.table.topLevelItem(0)
    assert row.text(1) == "Test" and "Timestamp" in row.text(2)
    plot = app.window.values.row("ExposureTime").plot
    app.until(lambda: len(plot.marks()) == 1 and plot.marks()[0] < 0)
    dialog.copyButton.click()
    assert "\tTest\tFrameID" in QGuiApplication.clipboard().text()
    dialog.clearButton.click()
    app.until(lambda: dialog.table.topLevelItemCount() == 0)
    dialog.closeButton.click()
    assert controls.events.dialog is None


def test_of_many_marks_the_last_are_shown_without_names(qtbot):
    plot = ChannelPlot()
    qtbot.addWidget(plot)
    plot.setMarks([(-float(number), "Edge") for number in range(MOST_MARKS + 5, 0, -1)])
    assert plot.marks() == [-float(number) for number in range(MOST_MARKS, 0, -1)]
    plot.setMarks([(-1.0, "Edge")])
    assert plot.marks() == [-1.0]
    plot.setMarks([])
    assert plot.marks() == []

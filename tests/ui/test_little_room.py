"""What the window does where there is little room, and that nothing in it jumps."""

from types import SimpleNamespace

import pytest
from PyQt5.QtCore import QRect
from PyQt5.QtWidgets import QDockWidget

from grabbergui.models.diagnosis import Stage
from grabbergui.ui.views.picture_view import PictureView
from grabbergui.ui.widgets.message_stack import MessageBar, MessageStack
from grabbergui.ui.widgets.status_strip import StateTone, StatusStrip
from grabbergui.ui.widgets.task_stack import TaskStack


@pytest.fixture
def strip(qtbot):
    made = StatusStrip()
    qtbot.addWidget(made)
    made.resize(900, 28)
    made.show()
    made.setState("Live", StateTone.GOOD)
    made.setFormat("2448 × 2048  BayerRG12p")
    made.setRates(9.9, 9)
    made.setBandwidth(40e6)
    made.setLosses(0, 0)
    return made


def test_the_whole_window_fits_800_pixels(window_desk):
    window_desk.connect()
    window = window_desk.window
    window.resize(800, 600)
    window_desk.until(lambda: window.width() == 800)
    assert window.height() == 600
    assert window.centre.minimumSizeHint().width() < 500


def test_the_figures_that_matter_least_make_way(strip):
    assert not any(label.isHidden() for label in strip._figures)
    strip.resize(strip.stateLabel.sizeHint().width() + 330, 28)
    assert not strip.lossLabel.isHidden()
    assert strip.bandwidthLabel.isHidden()
    strip.resize(900, 28)
    assert not strip.bandwidthLabel.isHidden()


def test_a_figure_with_a_digit_less_keeps_its_place(strip, qtbot):
    strip.setRates(100.0, 100)
    qtbot.waitUntil(lambda: strip.rateLabel.width() >= strip.rateLabel.sizeHint().width())
    before = strip.rateLabel.geometry()
    strip.setRates(1.0, 1)
    assert strip.rateLabel.minimumWidth() == before.width()
    strip.clearFigures()
    assert strip.rateLabel.minimumWidth() == 0


def test_an_invitation_stands_in_the_middle_and_a_problem_below(qtbot):
    view = PictureView()
    qtbot.addWidget(view)
    view.resize(640, 480)
    view.show()
    view.setNote("Nothing is connected.")
    middle = view.canvas.geometry().center().y()
    assert abs(view.note.geometry().center().y() - middle) < 5
    assert view.note.property("tone") == "info"
    view.setNote("No packet comes.", "Check the firewall.", Stage.PACKETS)
    assert view.note.geometry().top() > middle
    assert view.note.property("tone") == "busy"


def test_every_panel_can_be_open_on_800_pixels(window_desk):
    window = window_desk.window
    window_desk.connect()
    window.resize(800, 600)
    for dock in window.findChildren(QDockWidget):
        dock.show()
    window_desk.until(lambda: window.minimumSizeHint().width() > 700)  # they are laid out
    assert window.minimumSizeHint().width() <= 800 and window.width() == 800


@pytest.mark.parametrize(
    ("room", "taken"),
    [((1024, 600), (1024, 560)), ((1366, 768), (1280, 728)), ((1920, 1080), (1440, 800)),
     ((3840, 2160), (2880, 1590))],
)  # fmt: skip
def test_at_first_the_window_is_large_but_never_larger_than_the_screen(window_desk, monkeypatch, room, taken):
    window = window_desk.window
    screen = SimpleNamespace(availableGeometry=lambda: QRect(0, 0, *room))
    monkeypatch.setattr(window, "screen", lambda: screen)
    window.takeRoom()
    assert (window.width(), window.height()) == taken


def test_work_under_way_on_something_with_a_long_name_takes_no_more_room_than_there_is(qtbot):
    stack = TaskStack()
    qtbot.addWidget(stack)
    row = stack.begin("Connecting")
    before = stack.minimumSizeHint().width()
    row.setText("file:/" + "a-very-long-name" * 20)
    assert stack.minimumSizeHint().width() == before < 450
    assert row.textLabel.toolTip() == row.textLabel.text()


@pytest.mark.parametrize(
    ("told", "shown"),
    [("no camera answers", "No camera answers"), ("sim: is open already", "sim: is open already"),
     ("ExposureTime is locked", "ExposureTime is locked"), ("/data/x.mp4 is full", "/data/x.mp4 is full")],
)  # fmt: skip
def test_a_message_begins_large_unless_it_begins_with_a_name(qtbot, told, shown):
    stack = MessageStack()
    qtbot.addWidget(stack)
    stack.showError(told)
    bar = stack.findChild(MessageBar)
    assert bar.textLabel.text() == shown
    stack.showError(told)
    assert bar.textLabel.text() == f"{shown}  (×2)" and stack.messages == [told]


def test_the_picture_stays_where_it_is_under_a_message(window_desk):
    window = window_desk.window
    window_desk.connect()
    before = window.picture.geometry()
    window.messages.showNotice("saved " * 40)
    window_desk.until(lambda: window.messages.height() > 30)
    assert window.picture.geometry() == before
    assert window.messages.width() == before.width()
    bar = window.messages.findChild(MessageBar)
    corner = bar.closeButton.mapTo(window.centre, bar.closeButton.rect().center())
    assert window.centre.childAt(corner) is bar.closeButton

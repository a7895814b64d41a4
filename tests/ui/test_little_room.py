"""What the window does where there is little room, and that nothing in it jumps."""

import pytest

from grabbergui.models.diagnosis import Stage
from grabbergui.ui.views.picture_view import PictureView
from grabbergui.ui.widgets.status_strip import StateTone, StatusStrip


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

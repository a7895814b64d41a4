"""The robot in space: drawn, turned, and what lies behind the eye."""

import dataclasses

import numpy as np
import pytest
from PyQt5.QtCore import QEvent, QPoint, QPointF, Qt
from PyQt5.QtGui import QMouseEvent, QWheelEvent
from PyQt5.QtWidgets import QApplication

from grabbergui.calibration import geometry
from grabbergui.servo.models.servoing import Posture
from grabbergui.servo.robots import teo
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.ui.robot_view import NEAR, Orbit


def posture(**changes):
    robot = SimRobot(teo.MODEL)
    state = robot.state()
    board = geometry.pose(np.diag([1.0, -1.0, -1.0]), (0.6, -0.2, 0.3))
    made = Posture(
        robot.skeleton(state),
        state.hand,
        robot.camera_pose(state.head),
        np.array([(-0.5, -0.4, 1), (0.5, -0.4, 1), (0.5, 0.4, 1), (-0.5, 0.4, 1)]),
        board,
        state.hand,
        np.array([1.3, 0.0, 0.8]),
        (0.1, 0.1),
        (np.array([0.1, -0.9, -0.3]), np.array([0.8, 0.3, 0.9])),
    )
    return dataclasses.replace(made, **changes)


def hues(view):
    image = view.grab().toImage()
    return {
        image.pixelColor(x, y).name() for x in range(0, image.width(), 2) for y in range(0, image.height(), 2)
    }


def test_a_robot_is_drawn_with_its_marker(window):
    empty = hues(window.robotView)
    window.setPosture(posture())
    drawn = hues(window.robotView)
    assert len(drawn) > len(empty) + 50
    window.setPosture(None)
    assert len(hues(window.robotView)) < len(drawn)


@pytest.mark.parametrize(
    "changes",
    [
        {"marker": None, "goal": None, "person": None},
        {"sight": np.zeros((0, 3))},
        {"skeleton": []},
        {"hand": geometry.pose(None, (50.0, 50.0, 50.0))},
        {"marker": geometry.pose(None, (-50.0, 3.0, 50.0))},
    ],
    ids=["alone", "no sight", "no body", "far away", "behind the eye"],
)
def test_whatever_is_not_known_or_seen_is_left_out(window, changes):
    window.setPosture(posture(**changes))
    assert hues(window.robotView)


def move(view, x, y):
    """A mouse's move; the one of QTest forgets which button is held."""
    event = QMouseEvent(QEvent.MouseMove, QPointF(x, y), Qt.NoButton, Qt.LeftButton, Qt.NoModifier)
    QApplication.sendEvent(view, event)


def test_a_drag_turns_and_a_double_click_goes_back(window, qtbot):
    view = window.robotView
    view.setGeometry(0, 0, 400, 300)
    before = view.orbit
    qtbot.mousePress(view, Qt.LeftButton, pos=QPoint(100, 100))
    move(view, 150, 80)
    qtbot.mouseRelease(view, Qt.LeftButton, pos=QPoint(150, 80))
    assert view.orbit.azimuth < before.azimuth
    assert view.orbit.elevation < before.elevation
    turned = view.orbit
    move(view, 10, 10)
    assert view.orbit == turned
    qtbot.mouseDClick(view, Qt.LeftButton)
    assert view.orbit == before


def test_the_wheel_goes_nearer(window, qapp):
    view, middle = window.robotView, QPointF(50, 50)
    far = view.orbit.distance
    event = QWheelEvent(
        middle, middle, QPoint(), QPoint(0, 120), Qt.NoButton, Qt.NoModifier, Qt.NoScrollPhase, False
    )
    qapp.sendEvent(view, event)
    assert view.orbit.distance < far


def test_an_orbit_sees_its_centre_in_the_middle_and_up_as_up():
    orbit = Orbit(azimuth=1.0, elevation=0.3, distance=2.0)
    seen = orbit.seen([orbit.centre, np.add(orbit.centre, (0, 0, 0.1))])
    flat = orbit.flat(seen, 400, 300)
    assert flat[0] == pytest.approx((200, 150))
    assert seen[0] == pytest.approx((0, 0, 2.0))
    assert flat[1][0] == pytest.approx(200)
    assert flat[1][1] < 150


def test_a_line_is_cut_off_before_the_eye():
    orbit = Orbit()
    behind = np.array(orbit.centre) - 3 * orbit.distance * orbit.axes[2]
    for ends in ((orbit.centre, behind), (behind, orbit.centre)):
        flat, depths = orbit.line(ends, 400, 300)
        assert flat.shape == (1, 2, 2)
        assert np.isfinite(flat).all()
        assert depths[0] == pytest.approx((orbit.distance + NEAR) / 2)
    assert len(orbit.line([behind, behind], 400, 300)[0]) == 0

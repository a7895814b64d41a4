"""Bad input by real images: rendered, exposed and detected as in every run. No arm moves for any of it."""

import cv2
import numpy as np
import pytest

from grabbergui.calibration import geometry, markers
from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import UsageError
from grabbergui.driver.sim.rendered_scene import RenderedScene, Things, at, board_pose
from grabbergui.servo import closed_loop
from grabbergui.servo.state_machine import State

BOARD = board_pose()


class Fault:
    """A fault of the images from `begin` on."""

    problem = ""
    "What the loop must say of it, at some time."

    def begin(self, run, monkeypatch):
        run.things.board = self.board

    def board(self, seconds):
        return BOARD


class Flickering(Fault):
    """Seen in every other image."""

    problem = "no marker 20 is seen"

    def board(self, seconds):
        return BOARD if round(seconds * 25) % 2 else None


class Jumping(Fault):
    """A hand's breadth to and fro, from image to image."""

    problem = "is not sure yet"

    def board(self, seconds):
        aside = np.eye(4)
        aside[1, 3] = 0.12 * (round(seconds * 25) % 2)
        return aside @ BOARD


class EdgeOn(Fault):
    """Turned until hardly anything of it is to be seen."""

    problem = "marker 20"

    def board(self, seconds):
        return at(0.70, -0.32, 0.36, yaw=78)


class Behind(Fault):
    """Behind the robot's back, its face towards it."""

    problem = "no marker 20 is seen"

    def board(self, seconds):
        return at(-0.8, 0.2, 0.5, yaw=180)


class Twins(Fault):
    """Two boards with the marker's id, side by side."""

    problem = "several markers 20"

    def begin(self, run, monkeypatch):
        standing = RenderedScene._panels

        def twice(scene, seconds):
            panels = standing(scene, seconds)
            before = run.things.board
            run.things.board = lambda _: at(0.72, -0.12, 0.40)
            panels += standing(scene, seconds)[-1:]
            run.things.board = before
            return panels

        monkeypatch.setattr(RenderedScene, "_panels", twice)


class Solver(Fault):
    """The image is good, but the solver makes something else of it."""

    def begin(self, run, monkeypatch):
        right = cv2.solvePnPGeneric
        monkeypatch.setattr(markers.cv2, "solvePnPGeneric", lambda *a, **k: self.spoilt(*right(*a, **k)))


class NotANumber(Solver):
    problem = "no pose fits its corners"

    def spoilt(self, count, rotations, translations, errors):
        return count, rotations, [translation * np.nan for translation in translations], errors


class NegativeDepth(Solver):
    problem = "behind the camera"

    def spoilt(self, count, rotations, translations, errors):
        return count, rotations, [-translation for translation in translations], errors


class Ambiguous(Solver):
    """A second pose that explains the corners as well as the first."""

    problem = "two poses explain it"

    def spoilt(self, count, rotations, translations, errors):
        tilted = rotations[0] + np.array([[0.4], [0.0], [0.0]])
        return count, (rotations[0], tilted), translations, np.array([[0.05], [0.06]])


class Failing(Solver):
    problem = "no square's"

    def spoilt(self, *_):
        raise cv2.error("the solver fell over its own feet")


FAULTS = (
    Flickering,
    Jumping,
    EdgeOn,
    Behind,
    Twins,
    NotANumber,
    NegativeDepth,
    Ambiguous,
    Failing,
)


def started():
    """A run whose head looks at the board already; its images are rendered from now on only."""
    run = closed_loop.ClosedLoop(things=Things(face=lambda _: None, board=lambda _: BOARD), head=(-0.42, 0.1))
    run.rendered = False
    assert run.run(6, State.APPROACHING).state is State.APPROACHING
    run.rendered = True
    return run


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.__name__)
def test_an_approach_ends_within_200_ms(fault, monkeypatch):
    run, fault = started(), fault()
    run.run(0.3)
    assert run.robot.speed > 0.05
    fault.begin(run, monkeypatch)
    # The last good images are on their way still; from the first bad one on, nothing moves.
    run.run(run.latency + 1 / run.fps + 0.2)
    before = run.robot.state().arm
    reasons = set()
    for _ in range(40):
        cycle = run.cycle()
        reasons.add(cycle.reason)
        assert not cycle.command.hand.any()
    assert np.abs(run.robot.state().arm - before).max() < 1e-3
    assert any(fault.problem in reason for reason in reasons), reasons


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.__name__)
def test_no_approach_ever_begins(fault, monkeypatch):
    run, fault = closed_loop.ClosedLoop(things=Things(face=lambda _: None), head=(-0.42, 0.1)), fault()
    fault.begin(run, monkeypatch)
    for _ in range(75):
        assert not run.cycle().command.hand.any()
    assert run.gate.refused == 0


def test_without_a_fault_the_same_run_moves():
    run = started()
    assert any(cycle.command.hand.any() for cycle in (run.cycle() for _ in range(5)))


@pytest.fixture
def grey():
    """The board, not far from the middle."""
    run = closed_loop.ClosedLoop(things=Things(board=lambda _: BOARD), head=(-0.42, 0.1))
    return run._sensor.render(run._settings, 1, 0, np.empty(run._settings.image_bytes, np.uint8)).copy()


def test_a_mirrored_image_shows_no_marker(grey):
    finder = markers.ArucoDetector(calibration=closed_loop.calibration())
    assert len(finder.detect(grey)) == 1
    assert finder.detect(np.ascontiguousarray(grey[:, ::-1])) == []


def test_a_calibration_of_another_crop_is_an_error_not_a_pose(grey):
    finder = markers.ArucoDetector(calibration=closed_loop.calibration())
    with pytest.raises(UsageError, match="another crop"):
        finder.detect(np.ascontiguousarray(grey[:, 60:]))


@pytest.mark.parametrize("degrees", [20, 60, 120])
def test_an_assumed_field_of_view_may_be_wrong_but_gives_no_pose_that_is_none(grey, degrees):
    of = Calibration.from_field_of_view(closed_loop.WIDTH, closed_loop.HEIGHT, degrees)
    (marker,) = markers.ArucoDetector(calibration=of).detect(grey)
    assert (marker.pose is None) == bool(marker.problem)
    assert marker.pose is None or (geometry.is_pose(marker.pose) and marker.pose[2, 3] > 0)

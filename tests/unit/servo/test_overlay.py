"""The overlay is drawn where the things in the image are."""

import dataclasses
import math

import numpy as np
import pytest

from grabbergui.calibration.geometry import pose
from grabbergui.calibration.marker_pose import MarkerDetection
from grabbergui.core.calibration import Calibration
from grabbergui.servo import overlay
from grabbergui.servo.config import HeadConfig
from grabbergui.servo.detection import FaceDetection, Sighting
from grabbergui.servo.gate import Command
from grabbergui.servo.loop import ControlCycle
from grabbergui.servo.state_machine import State

CAMERA = Calibration(640, 480, np.array([[500.0, 0, 330], [0, 500.0, 230], [0, 0, 1]]), np.zeros(5))
CORNERS = np.array([[300.0, 200], [350, 200], [350, 250], [300, 250]])
FACING = pose(np.diag([1.0, -1.0, -1.0]), (0.0, 0.0, 1.0))


def cycle(off_centre=(math.nan, math.nan), state=State.CENTRING):
    return ControlCycle(1.0, state, "", Command(), off_centre, (0.05, 0.1), None)


def test_each_state_has_a_colour_of_its_own():
    assert len({overlay.colour_of(state) for state in State}) == len(State)


def strokes_of(drawing, colour):
    return [stroke for stroke in drawing.strokes if stroke.colour == colour]


def test_a_marker_has_its_outline_and_its_axes():
    marker = MarkerDetection(20, CORNERS, FACING)
    drawing = overlay.drawing(cycle(), Sighting(0.0, (marker,)), CAMERA)
    (outline, green_axis) = strokes_of(drawing, overlay.GOOD)
    assert outline.closed
    assert np.array_equal(outline.points, CORNERS)
    # Its y points up: half a decimetre at a metre's distance is 25 pixels.
    assert green_axis.points == pytest.approx(np.array([(330, 230), (330, 205)]))
    assert [label.text for label in drawing.labels] == ["id 20"]


def test_a_marker_without_a_pose_says_why():
    marker = MarkerDetection(7, CORNERS, None, "it is seen edge-on")
    drawing = overlay.drawing(cycle(), Sighting(0.0, (marker,)), CAMERA)
    assert drawing.labels[0].text == "id 7 it is seen edge-on"
    assert len(strokes_of(drawing, overlay.BAD)) == 1


def test_a_head_has_its_box_and_distance():
    head = FaceDetection((100, 50, 80, 90), (0.1, 0.0, 1.52))
    drawing = overlay.drawing(cycle(), Sighting(0.0, (), (head,)), CAMERA)
    (box,) = strokes_of(drawing, overlay.PERSON)
    assert box.points.min(axis=0).tolist() == [100, 50]
    assert box.points.max(axis=0).tolist() == [180, 140]
    assert drawing.labels[0].text == "1.5 m"


def test_the_deadband_lies_about_where_the_camera_looks_not_about_the_image_s_middle():
    config = HeadConfig(deadband=0.03, start=0.06)
    drawing = overlay.drawing(cycle(), None, CAMERA, config)
    frames = [stroke for stroke in drawing.strokes if stroke.closed]
    for frame, angle in zip(frames, (0.03, 0.06), strict=True):
        assert frame.points.mean(axis=0) == pytest.approx((330, 230))
        assert np.ptp(frame.points, axis=0) == pytest.approx((1000 * math.tan(angle),) * 2)


def test_a_line_leads_to_the_target():
    drawing = overlay.drawing(cycle((0.2, -0.1)), None, CAMERA)
    line, ring = strokes_of(drawing, overlay.colour_of(State.CENTRING))
    target = (330 + 500 * math.tan(0.2), 230 - 500 * math.tan(0.1))
    assert line.points == pytest.approx(np.array([(330, 230), target]))
    assert ring.points.mean(axis=0) == pytest.approx(target)


@pytest.mark.parametrize("off_centre", [(math.nan, math.nan), (2.0, 0.0), (0.0, -1.5)])
def test_no_line_leads_to_what_is_beside_or_behind(off_centre):
    drawing = overlay.drawing(cycle(off_centre), None, CAMERA)
    assert strokes_of(drawing, overlay.colour_of(State.CENTRING)) == []


def test_whatever_is_drawn_stays_where_painters_can_count():
    near = pose(np.diag([1.0, -1.0, -1.0]), (0.0, 0.0, 1e-9))
    strange = dataclasses.replace(MarkerDetection(20, CORNERS, FACING), pose=near)
    drawing = overlay.drawing(cycle(), Sighting(0.0, (strange,)), CAMERA)
    assert drawing.strokes and all(np.abs(stroke.points).max() <= 30_000 for stroke in drawing.strokes)


@pytest.mark.parametrize("state", State)
def test_every_state_has_a_colour_of_its_own_and_a_caption(state):
    image = np.full((480, 640, 3), 90, np.uint8)
    drawn = overlay.draw(image, cycle(state=state), None, CAMERA, HeadConfig())
    assert drawn.shape == image.shape
    assert (drawn[:20] != image[:20]).any()
    assert (image == 90).all()
    colours = [overlay.colour_of(other) for other in State]
    assert colours.count(overlay.colour_of(state)) == 1

"""A region of the sensor is moved and resized in the camera's steps, and never leaves the sensor."""

from hypothesis import given
from hypothesis import strategies as st

from every_case import every_case
from grabbergui.core.pixels import Region
from grabbergui.models.image.region_edit import AxisLimits, Grip, RegionLimits, dragged, grip_at

LIMITS = RegionLimits(AxisLimits(640, 64, 16, 4), AxisLimits(480, 32, 2, 2))
PART = Region(100, 50, 320, 240)


@every_case(
    ("grip", "by", "result"),
    [
        (Grip.MIDDLE, (9, -7), Region(108, 44, 320, 240)),
        (Grip.MIDDLE, (1000, 1000), Region(320, 240, 320, 240)),
        (Grip.MIDDLE, (-1000, -1000), Region(0, 0, 320, 240)),
        (Grip.RIGHT, (41, 999), Region(100, 50, 368, 240)),
        (Grip.RIGHT, (1000, 0), Region(100, 50, 528, 240)),
        (Grip.BOTTOM_RIGHT, (-1000, -1000), Region(100, 50, 64, 32)),
        (Grip.LEFT, (-31, 0), Region(68, 50, 352, 240)),
        (Grip.TOP_LEFT, (-1000, -1000), Region(4, 0, 416, 290)),
        (Grip.TOP_RIGHT, (16, 10), Region(100, 60, 336, 230)),
        (Grip.BOTTOM_LEFT, (16, 10), Region(116, 50, 304, 250)),
    ],
)
def test_a_part_is_dragged(grip, by, result):
    assert dragged(PART, grip, *by, LIMITS) == result


@given(
    st.sampled_from(Grip), st.integers(-2000, 2000), st.integers(-2000, 2000),
    st.integers(1, 32), st.integers(1, 8),
)  # fmt: skip
def test_whatever_is_dragged_stays_on_the_sensor_and_on_the_cameras_steps(grip, dx, dy, step, offset_step):
    axis = AxisLimits(1000, 32, step, offset_step)
    part = Region(offset_step * 3, offset_step * 5, 32 + 4 * step, 32 + 2 * step)
    region = dragged(part, grip, dx, dy, RegionLimits(axis, axis))
    for start, size in ((region.x, region.width), (region.y, region.height)):
        assert start >= 0 and start + size <= 1000 and start % offset_step == 0
        assert size >= 32 and (size - 32) % step == 0


@every_case(
    ("place", "grip"),
    [
        ((100, 50), Grip.TOP_LEFT),
        ((423, 51), Grip.TOP_RIGHT),
        ((98, 288), Grip.BOTTOM_LEFT),
        ((420, 290), Grip.BOTTOM_RIGHT),
        ((250, 47), Grip.TOP),
        ((250, 293), Grip.BOTTOM),
        ((97, 170), Grip.LEFT),
        ((417, 170), Grip.RIGHT),
        ((258, 172), Grip.MIDDLE),
        ((250, 170), None),
        ((250, 40), None),
        ((430, 170), None),
    ],
)
def test_the_part_under_the_mouse(place, grip):
    assert grip_at(PART, *place, reach=4) is grip

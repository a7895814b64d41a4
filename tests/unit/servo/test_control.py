"""Head and arm controllers, without images."""

import itertools
import math

import numpy as np
import pytest

from grabbergui.calibration import geometry
from grabbergui.servo.config import ArmConfig, HeadConfig
from grabbergui.servo.control import ArmController, HeadController, off_centre
from grabbergui.servo.robots import teo

DT = 0.02
AHEAD = geometry.pose([[0, 0, 1], [-1, 0, 0], [0, -1, 0]], (0, 0, 0.7))
"A camera 0.7 m above the base's origin that looks along its x axis."


def head(**changes):
    return HeadController(HeadConfig(**changes), teo.HEAD.low, teo.HEAD.high)


def point(right, down, away=1.0):
    return np.array([away, -away * math.tan(right), 0.7 - away * math.tan(down)])


@pytest.mark.parametrize(
    ("right", "down", "pan", "tilt"), [(0.2, 0, -1, 0), (-0.2, 0, 1, 0), (0, 0.2, 0, 1), (0, -0.2, 0, -1)]
)
def test_the_head_turns_to_where_the_target_is(right, down, pan, tilt):
    assert off_centre(point(right, down), AHEAD) == pytest.approx([right, down])
    assert np.sign(head().look(point(right, down), AHEAD, np.zeros(2))).tolist() == [pan, tilt]


def test_the_head_never_turns_faster_than_it_may():
    velocity = head(fastest=10).look(point(1.2, -0.9), AHEAD, np.zeros(2))
    assert np.degrees(np.abs(velocity)) == pytest.approx([10, 10])


def test_the_deadband_has_two_edges_so_that_the_head_does_not_jitter():
    controller, rest = head(deadband=0.03, start=0.05), np.zeros(2)
    assert not controller.look(point(0.04, 0), AHEAD, rest).any()
    assert controller.look(point(0.06, 0), AHEAD, rest).any()
    assert controller.look(point(0.04, 0), AHEAD, rest).any()
    assert not controller.look(point(0.02, 0), AHEAD, rest).any()
    assert not controller.look(point(0.04, 0), AHEAD, rest).any()


def test_a_joint_at_its_limit_is_not_pushed_and_counts_as_centred():
    controller = head()
    down = np.array([0.0, teo.HEAD.high[1]])
    assert not controller.look(point(0, 0.3), AHEAD, down).any()
    assert controller.centred(down)
    controller.look(point(0, 0.3), AHEAD, np.zeros(2))
    assert not controller.centred(np.zeros(2))


def test_the_head_turns_along_with_a_target_that_moves():
    velocity = np.array([0.0, -0.2, 0.1])
    turn = head().look(point(0, 0), AHEAD, np.zeros(2), velocity)
    assert turn == pytest.approx([-0.2, -0.1], rel=1e-3)
    at_limit = np.array([teo.HEAD.low[0], 0.0])
    turn = head().look(point(0, 0), AHEAD, at_limit, velocity)
    assert turn == pytest.approx([0.0, -0.1], rel=1e-3)


def test_a_moving_target_off_centre_is_turned_to_and_turned_with():
    velocity, place = np.array([0.0, -0.2, -0.1]), point(0.1, 0.05)
    still = head(gain=2).look(place, AHEAD, np.zeros(2))
    rate = (off_centre(place + 1e-4 * velocity, AHEAD) - off_centre(place, AHEAD)) / 1e-4
    moving = head(gain=2).look(place, AHEAD, np.zeros(2), velocity)
    assert still == pytest.approx([-0.2, 0.1])
    assert moving == pytest.approx(still - rate * (1, -1), rel=1e-3)


def test_steps_have_one_size_and_their_own_pace():
    controller = head(step=2.0, step_period=0.2)
    moves = [controller.step(point(0.3, -0.2), AHEAD, np.zeros(2), now) for now in np.arange(0, 1, 0.05)]
    made = [move for move in moves if move is not None]
    assert len(made) == 5
    assert np.degrees(made[0]) == pytest.approx([-2, -2])
    assert controller.step(point(0.01, 0.01), AHEAD, np.zeros(2), 5.0) is None


@pytest.mark.parametrize(("toward", "end"), [(-1, "low"), (1, "high")])
def test_a_step_ends_at_the_joint_s_limit(toward, end):
    limit = getattr(teo.HEAD, end)
    angles = limit - toward * np.radians([0.5, 0.5])
    move = head(step=2.0).step(point(-0.3 * toward, 0.3 * toward), AHEAD, angles, 0.0)
    assert angles + move == pytest.approx(limit)


def test_a_step_that_is_due_now_is_made():
    controller = head(step=2.0, step_period=0.2)
    assert controller.step(point(0.3, 0), AHEAD, np.zeros(2), 1.0) is not None
    assert controller.step(point(0.3, 0), AHEAD, np.zeros(2), 1.2) is not None


def test_other_settings_hold_from_the_next_command():
    controller = head(fastest=10)
    controller.tune(HeadConfig(fastest=20))
    velocity = controller.look(point(1.2, -0.9), AHEAD, np.zeros(2))
    assert np.degrees(np.abs(velocity)) == pytest.approx([20, 20])


def test_a_head_that_was_told_to_rest_starts_outside_the_wider_edge_only():
    controller, angles = head(deadband=0.03, start=0.05), np.zeros(2)
    assert controller.look(point(0.06, 0.06), AHEAD, angles).all()
    controller.rest()
    assert not controller.look(point(0.04, 0.04), AHEAD, angles).any()


def test_searching_looks_level_then_down_then_up_and_tilts_no_faster_than_it_pans():
    controller, angles, rows = head(search=20), np.zeros(2), []
    levels = {"level": 0.0, "down": 0.6 * teo.HEAD.high[1], "up": 0.6 * teo.HEAD.low[1]}
    for _ in range(6000):
        velocity = controller.search(angles)
        assert np.degrees(np.abs(velocity)).max() <= 20 + 1e-9
        angles = angles + velocity * DT
        row = next((name for name, tilt in levels.items() if abs(angles[1] - tilt) < 0.005), None)
        if row and rows[-1:] != [row]:
            rows.append(row)
    assert rows[:6] in (["level", "down", "level", "up", "level", "down"], ["level", "down", "up"] * 2)


def test_searching_sweeps_within_the_limits():
    controller, angles, seen = head(), np.array([0.3, 0.1]), []
    for _ in range(3000):
        angles = angles + controller.search(angles) * DT
        seen.append(angles)
    pan, tilt = np.array(seen).T
    assert min(pan) < -0.8
    assert max(pan) > 0.8
    # Level, down and up, each over the whole width.
    for row in (0.0, 0.6 * teo.HEAD.high[1], 0.6 * teo.HEAD.low[1]):
        there = pan[np.abs(tilt - row) < 0.02]
        assert max(there) - min(there) > 1.6
    assert np.all((teo.HEAD.low < seen) & (seen < teo.HEAD.high))


def marker_at(x=0.6, y=-0.3, z=0.4):
    upright = np.array([[0, 0, -1.0], [-1.0, 0, 0], [0, 1.0, 0]])
    return geometry.pose(upright, (x, y, z))


def arm(**changes):
    return ArmController(ArmConfig(**changes), 0.10)


def away(controller, marker, metres, turn=0.0):
    goal = controller.goal(marker)
    return geometry.pose(
        goal[:3, :3] @ geometry.rotation_from_vector((0, turn, 0)), goal[:3, 3] - (metres, 0, 0)
    )


def settled(controller, hand, marker, seconds=1.0):
    """The twist once the gradual start is over, the hand held where it is."""
    for _ in range(round(seconds / DT)):
        twist = controller.approach(hand, marker, DT)
    return twist


def test_the_goal_is_before_the_marker_with_the_hand_pointing_into_it():
    goal = arm().goal(marker_at())
    assert goal[:3, 3] == pytest.approx([0.5, -0.3, 0.4])
    assert goal[:3, 2] == pytest.approx([1, 0, 0])


def test_the_hand_comes_to_rest_at_the_goal_without_passing_it():
    controller, marker = arm(), marker_at()
    hand = away(controller, marker, 0.3, 0.6)
    for _ in range(500):
        hand = geometry.add_delta(hand, controller.approach(hand, marker, DT) * DT)
        assert hand[0, 3] <= controller.goal(marker)[0, 3] + 1e-9
    assert controller.arrived
    assert not controller.approach(hand, marker, DT).any()
    assert controller.error[0] <= 0.002
    assert math.degrees(controller.error[1]) <= 0.5


def test_it_starts_gradually_and_slows_down_on_its_way():
    controller, marker = arm(), marker_at()
    first = controller.approach(away(controller, marker, 0.3), marker, DT)
    assert np.linalg.norm(first[:3]) == pytest.approx(ArmConfig().acceleration * DT)
    speeds = [
        np.linalg.norm(settled(controller, away(controller, marker, metres), marker)[:3])
        for metres in (0.3, 0.05, 0.02, 0.01, 0.004)
    ]
    assert speeds[0] == pytest.approx(ArmConfig().fastest)
    assert all(a > b > 0 for a, b in itertools.pairwise(speeds))


@pytest.mark.parametrize("side", [-1, 1])
def test_it_starts_gradually_in_every_direction(side):
    config = ArmConfig()
    controller, marker = arm(), marker_at()
    goal = controller.goal(marker)
    turn = geometry.rotation_from_vector(side * 0.5 * np.ones(3))
    hand = geometry.pose(turn @ goal[:3, :3], goal[:3, 3] + side * 0.2 * np.ones(3))
    step = np.repeat((config.acceleration, math.radians(config.turn_acceleration)), 3) * DT
    assert controller.approach(hand, marker, DT) == pytest.approx(-side * step)
    assert controller.approach(hand, marker, DT) == pytest.approx(-side * 2 * step)


def test_a_hand_that_follows_speeds_up_eight_times_as_fast():
    controller, marker = arm(follow=0.5), marker_at()
    twist = controller.approach(controller.goal(marker), marker, DT, np.array([0.0, 0.4, 0.0]))
    assert twist[:3] == pytest.approx([0, 8 * ArmConfig().acceleration * DT, 0])


def test_a_hand_goes_no_faster_than_it_can_brake():
    controller, marker = arm(gain=10, fastest=0.5, fastest_turn=180), marker_at()
    hand = away(controller, marker, 0.05, 0.1)
    twist = settled(controller, hand, marker)
    assert np.linalg.norm(twist[:3]) == pytest.approx(math.sqrt(ArmConfig().acceleration * 0.05))
    braking = math.sqrt(math.radians(ArmConfig().turn_acceleration) * 0.1)
    assert np.linalg.norm(twist[3:]) == pytest.approx(braking)


def test_the_error_is_the_norm_over_all_axes():
    controller, marker = arm(), marker_at()
    goal = controller.goal(marker)
    turn = geometry.rotation_from_vector((0.1, 0.2, 0.2))
    hand = geometry.pose(turn @ goal[:3, :3], goal[:3, 3] + (0.01, 0.02, 0.02))
    controller.measure(hand, marker)
    assert controller.error == pytest.approx((0.03, 0.3))
    controller.rest()
    controller.error = (math.inf, math.inf)
    controller.approach(hand, marker, DT)
    assert controller.error == pytest.approx((0.03, 0.3))


def test_a_resting_hand_starts_again_only_when_it_is_clearly_off():
    controller, marker = arm(), marker_at()
    deadband = ArmConfig().deadband
    for metres, moves in ((0.9, False), (1.9, False), (2.1, True), (1.1, True), (0.9, False)):
        twist = controller.approach(away(controller, marker, metres * deadband), marker, DT)
        assert bool(twist.any()) is moves, metres


def test_a_hand_rests_as_a_whole_and_stays_at_rest_though_nothing_is_commanded():
    """It came to rest 3.2 mm from its goal: turning moved it after it had ceased to correct its place."""
    controller, marker = arm(), marker_at()
    twist = controller.approach(away(controller, marker, 0.0015, 0.1), marker, DT)
    assert twist[:3].any() and twist[3:].any() and not controller.settled
    hand = away(controller, marker, 0.0015, math.radians(0.4))
    for _ in range(3):
        assert not controller.approach(hand, marker, DT).any() and controller.settled
        controller.rest()  # as the loop does, because the twist is zero
        hand = away(controller, marker, 0.0035, math.radians(0.9))


def test_noise_at_the_goal_does_not_move_the_hand():
    controller, marker, random = arm(), marker_at(), np.random.default_rng(2)
    hand = away(controller, marker, 0.001)
    assert not settled(controller, hand, marker).any()
    for _ in range(200):
        shaken = geometry.add_delta(marker, random.normal(0, 0.0006, 6))
        assert not controller.approach(hand, shaken, DT).any()


@pytest.mark.parametrize("marker", [marker_at(x=1.2), marker_at(y=0.8), marker_at(z=-0.6)])
def test_a_goal_outside_the_workspace_is_not_approached(marker):
    controller = arm()
    assert not settled(controller, away(controller, marker_at(), 0.2), marker).any()


def test_the_arm_s_other_settings_hold_from_the_next_command():
    controller, marker = arm(fastest=0.05), marker_at()
    hand = away(controller, marker, 0.3)
    assert np.linalg.norm(settled(controller, hand, marker)[:3]) == pytest.approx(0.05)
    controller.tune(ArmConfig(fastest=0.1))
    assert np.linalg.norm(settled(controller, hand, marker)[:3]) == pytest.approx(0.1)


def test_no_twist_comes_from_numbers_that_are_none():
    controller, bad = arm(), marker_at()
    bad[0, 3] = np.nan
    assert not controller.approach(away(controller, marker_at(), 0.2), bad, DT).any()

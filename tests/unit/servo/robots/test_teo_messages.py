"""TEO's messages against those of real control boards and Cartesian controllers, recorded."""

import math
from pathlib import Path

import numpy as np
import pytest

from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.values import Dialect
from grabbergui.servo.robots import teo, teo_messages
from grabbergui.servo.robots.cartesian_messages import (
    TWIST,
    announce,
    base_frame,
    read_status,
    stop_control,
)
from grabbergui.servo.robots.teo_ports import joint_velocities

DATA = Path(__file__).parents[3] / "data" / "yarp"


def recorded(name, letters):
    lines = [line.split() for line in (DATA / name).read_text().splitlines() if not line.startswith("#")]
    return [(letter, bytes.fromhex(data)) for letter, data in lines if letter in letters]


BOARDS = pytest.mark.parametrize(
    ("dialect", "file"),
    [(Dialect.YARP3, "control_board_312.txt"), (Dialect.YARP4, "control_board_40.txt")],
    ids=["3.12", "4.0"],
)


@BOARDS
def test_a_real_boards_encoders_are_read(dialect, file):
    for _, data in recorded(file, "S"):
        assert np.isfinite(teo_messages.read_encoders(Bottle.decode(data), 2)).all()
        assert teo_messages.encoders(np.zeros(2)).encode(dialect)[:8] == data[:8]


@BOARDS
def test_what_a_board_streams_of_all_kinds_has_the_real_ones_layout(dialect, file):
    (_, real), *_ = recorded(file, "E")
    modes = [teo_messages.POSITION_MODE] * 2
    ours = teo_messages.extended_state(np.zeros(2), modes, dialect)
    real_items = Bottle.decode(real, dialect)
    for mine, theirs in zip(ours, real_items, strict=True):
        assert isinstance(mine, list) == isinstance(theirs, list)
        if isinstance(mine, list):
            assert [type(item) for item in mine] == [type(item) for item in theirs]
    assert len(ours.encode(dialect)) == len(real)


@BOARDS
def test_our_velocities_are_those_of_a_real_client(dialect, file):
    real = next(data for letter, data in recorded(file, "C"))
    velocity = teo_messages.read_board_command(Bottle.decode(real), 2).values
    assert np.degrees(velocity) == pytest.approx([5.0, 5.0])
    ours = teo_messages.velocity_moves(velocity, dialect).encode(dialect)
    assert ours[:-16] == real[:-16]  # all but the numbers themselves
    assert len(ours) == len(real)


def test_our_streamed_positions_are_those_of_a_real_client_of_4():
    ours = teo_messages.direct_positions(np.radians([4.0, 3.0]), Dialect.YARP4).encode(Dialect.YARP4)
    real = [data for _, data in recorded("control_board_40.txt", "C")]
    assert ours[:-16] in [data[:-16] for data in real]
    read = [teo_messages.read_board_command(Bottle.decode(data), 2) for data in real]
    assert [(str(command.mode), command.joints) for command in read] == [
        *[("vel", [0, 1]), ("vel", [0]), ("vel", [1])],
        *[("posd", [0, 1]), ("posd", [0]), ("posd", [0])],
    ]


def test_our_requests_are_those_of_a_real_client_of_4():
    real = [data for _, data in recorded("control_board_40.txt", "Q")]
    for ours in (
        teo_messages.control_modes(teo_messages.DIRECT_MODE, 2, Dialect.YARP4),
        teo_messages.relative_moves(np.radians([2.0, 2.0]), Dialect.YARP4),
    ):
        assert ours.encode(Dialect.YARP4) in real
    for ours in (teo_messages.axes(Dialect.YARP4), teo_messages.stop_all(Dialect.YARP4)):
        # Lone words may go without their type code: 4.0 reads both.
        ours.specialised = False
        assert ours.encode(Dialect.YARP4) in real


def test_a_real_controllers_pose_is_that_of_our_kinematics():
    """KdlSolver had TEO's table and stood where we start."""
    (_, data), *_ = recorded("cartesian_control_312.txt", "S")
    hand = read_status(Bottle.decode(data))
    assert hand == pytest.approx(teo.RIGHT_ARM.forward(np.radians([-20, -5, 0, -80, 0, 20])), abs=1e-9)


@pytest.mark.parametrize(
    "request_of_ours",
    [
        announce(TWIST),
        base_frame(),
        stop_control(),
    ],
)
def test_our_requests_are_those_of_a_real_client(request_of_ours):
    assert request_of_ours.encode() in [data for _, data in recorded("cartesian_control_312.txt", "Q")]


def arm_at(**degrees):
    """TEO's joint angles at home but for some, in radians."""
    angles = teo.HOME.copy()
    for name, value in degrees.items():
        angles[teo.RIGHT_ARM.joint_names.index(name)] = math.radians(value)
    return angles


def test_a_streamed_twist_becomes_the_joint_velocities_of_the_pseudo_inverse():
    twist = np.array([0.05, -0.03, 0.02, 0.1, 0.0, -0.2])
    velocities = joint_velocities(teo.RIGHT_ARM, teo.HOME, twist)
    assert teo.RIGHT_ARM.jacobian(teo.HOME) @ velocities == pytest.approx(twist)


@pytest.mark.parametrize(
    ("angles", "twist", "moves"),
    [
        (arm_at(FrontalRightWrist=44.7), (0, 0, 0, 0, 0.3, 0), False),
        (arm_at(FrontalRightWrist=44.7), (0, 0, 0, 0, -0.3, 0), True),
        (teo.HOME, (0, -0.6, 0, 0, 0, 0), False),
    ],
    ids=["at its end, outwards", "at its end, inwards", "too fast"],
)
def test_the_whole_arm_stops_where_one_joint_cannot_follow(angles, twist, moves):
    velocities = joint_velocities(teo.RIGHT_ARM, angles, np.array(twist, float))
    assert bool(velocities.any()) == moves

"""TEO moved in each mode: control boards of YARP 3.x and 4.0, Cartesian controllers of both versions."""

import numpy as np
import pytest

from grabbergui.calibration import geometry
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.values import Dialect, Vocab
from grabbergui.servo.config import Config
from grabbergui.servo.gate import Command, CommandGate
from grabbergui.servo.robots import teo, teo_messages
from grabbergui.servo.robots.cartesian_messages import read_cartesian_command, streamed_pose
from grabbergui.servo.robots.leading_target import HAND_SLACK, HEAD_SLACK, leading_hand, leading_head
from robots_for_tests import RecordingRobot

LEAD = 0.1
"Seconds that positions are ahead."
DIALECTS = pytest.mark.parametrize("dialect", Dialect, ids=lambda dialect: dialect.value)


def followed(leading, here, velocity, times, follow):
    """Targets for a part that is moved on to each by `follow`."""
    targets = []
    for now in times:
        targets.append(leading.advance(here, velocity, LEAD, now))
        here = follow(here, targets[-1])
    return targets


def test_a_leading_target_moves_at_the_speed_that_is_wanted():
    velocity = np.array([0.4, -0.2])
    times = np.arange(0, 1, 0.02)
    targets = followed(leading_head(), np.zeros(2), velocity, times, lambda _, target: target)
    assert np.diff(targets, axis=0) == pytest.approx(np.tile(velocity * 0.02, (len(times) - 1, 1)))


def test_a_leading_target_waits_for_a_head_that_does_not_move():
    velocity = np.array([0.4, 0.0])
    targets = followed(leading_head(), np.zeros(2), velocity, np.arange(0, 2, 0.02), lambda here, _: here)
    assert targets[-1] == pytest.approx([0.4 * LEAD + HEAD_SLACK, 0.0])


def test_a_leading_target_waits_for_a_hand_that_does_not_move():
    here = teo.RIGHT_ARM.forward(teo.HOME)
    twist = np.array([0.1, 0, 0, 0, 0, 0.5])
    target = followed(leading_hand(), here, twist, np.arange(0, 2, 0.02), lambda here, _: here)[-1]
    expected = np.array([0.1 * LEAD + HAND_SLACK[0], 0, 0, 0, 0, 0.5 * LEAD + HAND_SLACK[1]])
    assert geometry.diff(here, target) == pytest.approx(expected)


def test_a_joint_that_is_held_does_not_follow_its_own_sinking():
    """The tilt gives way a little all the time; its target must stay."""
    sinking = lambda here, target: np.array([target[0], target[1] - 0.001])  # noqa: E731
    velocity = np.array([0.4, 0.0])
    targets = followed(leading_head(), np.zeros(2), velocity, np.arange(0, 1, 0.02), sinking)
    assert targets[-1][1] == 0.0


def test_a_leading_target_begins_where_the_part_is_after_a_pause():
    leading, velocity = leading_head(), np.array([0.4, 0.0])
    leading.advance(np.zeros(2), velocity, LEAD, 0.0)
    here = np.array([0.3, 0.0])
    assert leading.advance(here, velocity, LEAD, 1.0) == pytest.approx(here + velocity * 0.02)


class Leading(RecordingRobot):
    """Remembers how far ahead it was to be."""

    def lead_head(self, velocity, seconds):
        self._hear(("lead head", velocity * seconds))

    def lead_hand(self, twist, seconds):
        self._hear(("lead hand", twist * seconds))


@pytest.mark.parametrize(
    ("text", "heard"),
    [
        ("", ["head", "hand"]),
        ("[head]\nmode = direct\n[arm]\nmode = direct", ["lead head", "lead hand"]),
        ("[arm]\nmode = direct", ["head", "lead hand"]),
        ("[head]\nmode = steps", ["lead head", "hand"]),
    ],
)
def test_the_gate_moves_each_part_in_its_mode(text, heard):
    robot = Leading()
    gate = CommandGate(robot, Config.parse(text))
    assert gate.send(Command(np.array([0.1, 0.0]), None, np.array([0.02, 0, 0, 0, 0, 0])), 0.0)
    assert [kind for kind, _ in robot.moves] == heard
    gate.halt("enough")
    assert robot.stops


@DIALECTS
def test_what_is_asked_of_a_board_is_one_table_in_both_dialects(dialect):
    requests = (
        teo_messages.axes(dialect),
        teo_messages.stop_all(dialect),
        teo_messages.control_modes(teo_messages.DIRECT_MODE, 2, dialect),
        teo_messages.relative_moves(np.radians([1.0, 2.0]), dialect),
    )
    texts = {
        Dialect.YARP3: ["[get] [axes]", "[set] [stos]", "[set] [icmd] [cmds] ([posd] [posd])"],
        Dialect.YARP4: ["getAxesRPC", "stopAllRPC", "setControlModeAllRPC (1685286768 1685286768)"],
    }[dialect]
    moves = {Dialect.YARP3: "[set] [rels]", Dialect.YARP4: "relativeMoveAllRPC"}[dialect]
    assert [request.to_text() for request in requests] == [*texts, f"{moves} (1.0 2.0)"]


@DIALECTS
def test_streamed_commands_are_read_as_they_are_written(dialect):
    angles = np.array([0.1, -0.2])
    for write, mode in (
        (teo_messages.velocity_moves, teo_messages.VELOCITY_MODE),
        (teo_messages.direct_positions, teo_messages.DIRECT_MODE),
    ):
        read = teo_messages.read_board_command(Bottle.decode(write(angles, dialect).encode(dialect)), 2)
        assert (read.mode, read.joints) == (mode, [0, 1])
        assert read.values == pytest.approx(angles)
    hand = teo.RIGHT_ARM.forward(teo.HOME)
    pose = streamed_pose(hand, Vocab("pose")).encode(dialect)
    vector = read_cartesian_command(Bottle.decode(pose), "pose")
    assert geometry.pose_from_vector(vector) == pytest.approx(hand)

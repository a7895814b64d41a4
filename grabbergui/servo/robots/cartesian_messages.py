"""Messages to and from a Cartesian controller on YARP (roboticslab's ICartesianControl). No I/O.

Metres, radians, and rotation vectors. It obeys streamed commands after an announcement. The command for a
pose is called `pose` since May 2024 and `movi` before.
"""

from __future__ import annotations

from collections.abc import Sequence

from grabbergui.calibration.geometry import Pose, Vector, pose_from_vector, vector_from_pose
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.values import Vocab, word
from grabbergui.servo.robots.teo_messages import numbers

NOT_CONTROLLING = Vocab("ccnc")
"A controller's state without a motion, in which it also obeys streamed commands."
TWIST = Vocab("twst")
POSE_WORDS = (Vocab("movi"), Vocab("pose"))
"""The words for a streamed pose, in the order in which to try them.

Until February 2023 there was a `pose` beside `movi`, which took its first number for an interval.
"""


def announce(command: Vocab) -> Bottle:
    """The request that gets a controller ready for one kind of streamed command."""
    return Bottle([Vocab("set"), Vocab("cpsc"), command])


def base_frame() -> Bottle:
    """The request that makes a controller take motions as along the base's axes, not the hand's."""
    return Bottle([Vocab("set"), Vocab("cpf"), Vocab("cpfb")])


def stop_control() -> Bottle:
    """The request that ends whatever a controller does."""
    return Bottle([Vocab("stop")])


def ask_status() -> Bottle:
    """The request for a controller's status, which moves nothing."""
    return Bottle([Vocab("stat")])


def twist(values: Vector) -> Bottle:
    """A streamed twist, m/s and rad/s."""
    return Bottle([TWIST, *map(float, values)])


def streamed_pose(hand: Pose, command: Vocab) -> Bottle:
    """A streamed pose under the word that was announced, which the drives go to at once."""
    return Bottle([command, *map(float, vector_from_pose(hand))])


def read_cartesian_command(message: Bottle, announced: str) -> Vector | None:
    """Six numbers of a streamed command; None for one of another kind. Raises RemoteProtocolError."""
    return numbers(message[1:], 6) if message and word(message[0]) == announced else None


def status(state: Vocab, hand: Pose, time: float) -> Bottle:
    """Return the status that a controller streams, and its reply to `stat`."""
    return Bottle([state, *map(float, vector_from_pose(hand)), float(time)])


def read_status(message: Sequence[object]) -> Pose:
    """The hand's pose in a status, with or without the time at its end. Raises RemoteProtocolError."""
    return pose_from_vector(numbers(Bottle(message)[1:7], 6))  # type: ignore[arg-type]

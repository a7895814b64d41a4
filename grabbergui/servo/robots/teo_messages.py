"""Messages of TEO's control boards and Cartesian controllers on YARP. No I/O.

Control boards speak `remote_controlboard`: angles in degrees, streamed commands as a pair of lists, encoders
as a plain list. Cartesian controllers speak the vocabularies of roboticslab's ICartesianControl: metres,
radians, rotation vectors.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from grabbergui.calibration.geometry import Pose, Vector, pose_from_vector, vector_from_pose
from grabbergui.core.errors import RemoteProtocolError
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.values import Item, Vocab, word

OK, FAIL = Vocab("ok"), Vocab("fail")
NOT_CONTROLLING = Vocab("ccnc")
"A Cartesian controller's state, that in which streamed commands are obeyed too."
POSITION_MODE, VELOCITY_MODE = Vocab("pos"), Vocab("vel")


# -- control board -------------------------------------------------------------------------------
def velocity_moves(velocity: Vector) -> Bottle:
    """A streamed velocity for all joints, given in rad/s."""
    return Bottle([[Vocab("vmos")], degrees(velocity)])


def read_velocity_moves(message: Bottle, held: Vector) -> Vector | None:
    """Rad/s of all joints after such a command, for all, some or one of them; `held` are those before.

    None where it is another command. Raises RemoteProtocolError.
    """
    if len(message) != 2 or not isinstance(message[0], list):
        return None
    verb, *rest = [*message[0], ""]
    if word(verb) == "vmos":
        return np.radians(numbers(message[1], len(held)))
    if word(verb) == "vmo":
        which = joints(rest[:1], len(held))
    elif word(verb) == "vmog":
        which = joints(rest[1], len(held))
    else:
        return None
    velocity = held.copy()
    velocity[which] = np.radians(numbers(message[1], len(which)))
    return velocity


def relative_moves(move: Vector) -> Bottle:
    """The request for a relative move of all joints, given in radians."""
    return Bottle([Vocab("set"), Vocab("rels"), degrees(move)])


def control_modes(mode: Vocab, joints: int) -> Bottle:
    """The request that puts all joints into one mode."""
    modes: list[Item] = [mode] * joints
    return Bottle([Vocab("set"), Vocab("icmd"), Vocab("cmds"), modes])


def stop_all() -> Bottle:
    """The request that stops all joints."""
    return Bottle([Vocab("set"), Vocab("stos")])


def axes() -> Bottle:
    """The request for the number of joints, which moves nothing."""
    return Bottle([Vocab("get"), Vocab("axes")])


def encoders(angles: Vector) -> Bottle:
    """Return the reading that a control board streams, from radians."""
    return Bottle(degrees(angles))


def extended_state(angles: Vector, modes: Sequence[Vocab]) -> Bottle:
    """All that a control board streams: each kind of value with whether it is known.

    Known are positions (radians here) and control modes; not speeds, accelerations, those three of the
    motors, torques, duty cycles, currents, and modes of interaction.
    """
    nothing: list[Item] = [0.0] * len(angles)
    unknown: list[Item] = [nothing, FAIL] * 8
    # Modes go as plain integers here, or a reader refuses the whole message.
    numbered: list[Item] = [int(mode) for mode in modes]
    return Bottle([degrees(angles), OK, *unknown, numbered, OK, [0] * len(angles), FAIL])


def read_encoders(message: Bottle, joints: int) -> Vector:
    """Radians of a streamed reading. Raises RemoteProtocolError."""
    return np.radians(numbers(message, joints))


# -- Cartesian controller ------------------------------------------------------------------------
def twist(values: Vector) -> Bottle:
    """A streamed twist, m/s and rad/s."""
    return Bottle([Vocab("twst"), *map(float, values)])


def read_twist(message: Bottle) -> Vector | None:
    """The twist of such a command; None where it is another. Raises RemoteProtocolError."""
    return numbers(message[1:], 6) if message and word(message[0]) == "twst" else None


def expect_twists() -> Bottle:
    """The request that gets a controller ready for streamed twists."""
    return Bottle([Vocab("set"), Vocab("cpsc"), Vocab("twst")])


def base_frame() -> Bottle:
    """The request that makes a controller take motions as along the base's axes, not the hand's."""
    return Bottle([Vocab("set"), Vocab("cpf"), Vocab("cpfb")])


def stop_control() -> Bottle:
    """The request that ends whatever a controller does."""
    return Bottle([Vocab("stop")])


def ask_status() -> Bottle:
    """The request for a controller's status, which moves nothing."""
    return Bottle([Vocab("stat")])


def status(state: Vocab, hand: Pose, time: float) -> Bottle:
    """Return the status that a controller streams, and its reply to `stat`."""
    return Bottle([state, *map(float, vector_from_pose(hand)), float(time)])


def read_status(message: Bottle) -> Pose:
    """The hand's pose in a status, with or without the time at its end. Raises RemoteProtocolError."""
    return pose_from_vector(numbers(message[1:7], 6))


def succeeded(reply: Bottle | None) -> bool:
    """Whether a reply begins or ends with `ok`: controllers say it first, control boards last."""
    return bool(reply) and "ok" in (word(reply[0]), word(reply[-1]))  # type: ignore[index]


def numbers(items: Item | Sequence[Item], count: int) -> Vector:
    """So many finite numbers. Raises RemoteProtocolError."""
    if not isinstance(items, list) or len(items) != count:
        raise RemoteProtocolError(f"{count} numbers were expected, not {str(items)[:60]}")
    if not all(isinstance(item, (int, float)) for item in items):
        raise RemoteProtocolError(f"something in {str(items)[:60]} is no number")
    values = np.array([float(item) for item in items], np.float64)  # type: ignore[arg-type]
    if not np.isfinite(values).all():
        raise RemoteProtocolError(f"something in {str(items)[:60]} is not finite")
    return values


def joints(items: Item | Sequence[Item], count: int) -> list[int]:
    """Indices of joints, of which there are `count`. Raises RemoteProtocolError."""
    indices = [item for item in items if isinstance(item, int)] if isinstance(items, list) else []
    if not indices or items != indices or not all(0 <= index < count for index in indices):
        raise RemoteProtocolError(f"joints are 0 to {count - 1}, not {str(items)[:60]}")
    return indices


def degrees(angles: Vector) -> list[Item]:
    """Radians as control boards have them."""
    return [float(value) for value in np.degrees(angles)]

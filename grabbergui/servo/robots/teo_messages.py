"""Messages to and from the control boards of TEO on YARP (`remote_controlboard`, 3.x and 4.0). No I/O.

Angles are degrees. A request is a row of vocabularies in 3.x (`[set] [stos]`) and a method's name in 4.0's
thrift service `ControlBoardMsgs` (`stopAllRPC`); one table, `METHODS`, has both. A streamed command is a pair
of a list of words and a vector; in 4.0 the name of an interface stands before the verb. Both stream encoders
as a vector, and all their readings as lists, each followed by whether it is valid.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grabbergui.calibration.geometry import Vector
from grabbergui.core.errors import RemoteProtocolError
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.values import Dialect, Float32, Item, Vocab, word

OK, FAIL = Vocab("ok"), Vocab("fail")
POSITION_MODE, DIRECT_MODE, VELOCITY_MODE = Vocab("pos"), Vocab("posd"), Vocab("vel")
"The modes in which a drive obeys moves by request, streamed positions, and velocities."
METHOD_FAILED = Vocab("err5")
"A `ReturnValue` of 4.0."
RPC_PORTS = {Dialect.YARP4: "/nws/rpc:i", Dialect.YARP3: "/rpc:i"}
"Suffix of a board's port for requests."

METHODS = {
    "getAxesRPC": "get axes",
    "getAxisNameRPC": "get name",
    "getEncoderAllRPC": "get encs",
    "getEncoderOneRPC": "get enc",
    "getPosLimitsRPC": "get llim",
    "getVelLimitsRPC": "get vlim",
    "getTrajSpeedsAllRPC": "get vels",
    "getTrajSpeedOneRPC": "get vel",
    "checkMotionDoneAllRPC": "get dons",
    "setTrajSpeedAllRPC": "set vels",
    "setTrajSpeedOneRPC": "set vel",
    "setControlModeAllRPC": "set icmd cmds",
    "setControlModeOneRPC": "set icmd cmod",
    "positionMoveAllRPC": "set poss",
    "positionMoveOneRPC": "set pos",
    "relativeMoveAllRPC": "set rels",
    "relativeMoveOneRPC": "set rel",
    "stopAllRPC": "set stos",
    "stopOneRPC": "set sto",
}
"4.0's methods with the words of 3.x that ask for the same, and take the same arguments."
_METHOD_FOR = {words: method for method, words in METHODS.items()}

_STREAMED = {
    **{"vmos": VELOCITY_MODE, "vmo": VELOCITY_MODE, "vmog": VELOCITY_MODE},
    **{"dpos": DIRECT_MODE, "dpo": DIRECT_MODE, "dpog": DIRECT_MODE},
}
_INTERFACES = {"ivel": VELOCITY_MODE, "ipod": DIRECT_MODE}


def axes(dialect: Dialect = Dialect.YARP3) -> Bottle:
    """The request for the number of joints, which moves nothing."""
    return _request("get axes", dialect=dialect)


def control_modes(mode: Vocab, joints: int, dialect: Dialect = Dialect.YARP3) -> Bottle:
    """The request that puts all joints into one mode."""
    # An enumeration of thrift is an integer.
    modes: list[Item] = [mode if dialect is Dialect.YARP3 else int(mode)] * joints
    return _request("set icmd cmds", modes, dialect=dialect)


def relative_moves(move: Vector, dialect: Dialect = Dialect.YARP3) -> Bottle:
    """The request for a relative move of all joints, given in radians."""
    return _request("set rels", degrees(move), dialect=dialect)


def stop_all(dialect: Dialect = Dialect.YARP3) -> Bottle:
    """The request that stops all joints."""
    return _request("set stos", dialect=dialect)


def succeeded(reply: Bottle | None) -> bool:
    """Return whether a reply has `ok`, first as in 4.0 and Cartesian controllers, or last as in 3.x."""
    if not reply:
        return False
    first = reply[0][0] if isinstance(reply[0], list) and reply[0] else reply[0]
    return "ok" in (word(first), word(reply[-1]))


def _request(words: str, *arguments: Item, dialect: Dialect) -> Bottle:
    if dialect is Dialect.YARP4:
        return Bottle([_METHOD_FOR[words], *arguments])
    return Bottle([*map(Vocab, words.split()), *arguments])


@dataclass(frozen=True, eq=False)
class Streamed:
    """A streamed command."""

    mode: Vocab
    "The mode in which it is obeyed: VELOCITY_MODE or DIRECT_MODE."
    joints: list[int]
    values: Vector
    "Radians or rad/s, one for each of the joints."


def velocity_moves(velocity: Vector, dialect: Dialect = Dialect.YARP3) -> Bottle:
    """A streamed velocity for all joints, given in rad/s."""
    return _streamed("ivel", "vmos", velocity, dialect)


def direct_positions(angles: Vector, dialect: Dialect = Dialect.YARP3) -> Bottle:
    """A streamed position for all joints, given in radians, which drives go to at once."""
    return _streamed("ipod", "dpos", angles, dialect)


def read_board_command(message: Bottle, count: int) -> Streamed | None:
    """Read a command of either dialect for all, some or one of `count` joints.

    None for commands of other kinds. Raises RemoteProtocolError.
    """
    if len(message) != 2 or not isinstance(message[0], list):
        return None
    words: list[Item] = [*message[0], "", ""]
    if word(words[0]) in _INTERFACES:
        words = words[1:]
    verb = word(words[0])
    mode = _STREAMED.get(verb)
    if mode is None:
        return None
    if verb.endswith("s"):
        which = list(range(count))
    else:
        which = joints(words[2] if verb.endswith("g") else words[1:2], count)
    return Streamed(mode, which, np.radians(numbers(message[1], len(which))))


def _streamed(interface: str, verb: str, values: Vector, dialect: Dialect) -> Bottle:
    words = [interface, verb] if dialect is Dialect.YARP4 else [verb]
    return Bottle([Bottle(map(Vocab, words)), degrees(values)])


def encoders(angles: Vector) -> Bottle:
    """Return the reading that a control board streams, from radians."""
    return Bottle(degrees(angles))


def read_encoders(message: Bottle, joints: int) -> Vector:
    """Radians of a streamed reading. Raises RemoteProtocolError."""
    return np.radians(numbers(message, joints))


def extended_state(angles: Vector, modes: Sequence[Vocab], dialect: Dialect = Dialect.YARP3) -> Bottle:
    """Return the whole state that a control board streams: each kind of value with whether it is known.

    Known are positions (radians here) and control modes; not speeds, accelerations, those three of the
    motors, torques, duty cycles, currents, and modes of interaction; nor temperatures, which 4.0 has too.
    """
    joints = len(angles)
    nothing: list[Item] = [0.0] * joints
    # A reader of 4.0 takes duty cycles and temperatures as single precision only.
    single: list[Item] = [Float32(0.0)] * joints if dialect is Dialect.YARP4 else nothing
    # Modes go as plain integers here, or a reader refuses the whole message.
    numbered: list[Item] = [int(mode) for mode in modes]
    unknown: list[Item] = [nothing, FAIL] * 6
    unknown += [single, FAIL, nothing, FAIL]
    temperatures: list[Item] = [single, FAIL] if dialect is Dialect.YARP4 else []
    return Bottle([degrees(angles), OK, *unknown, numbered, OK, [0] * joints, FAIL, *temperatures])


def numbers(items: Item | Sequence[Item], count: int) -> Vector:
    """Return `count` finite numbers. Raises RemoteProtocolError."""
    if not isinstance(items, list) or len(items) != count:
        raise RemoteProtocolError(f"{count} numbers were expected, not {str(items)[:60]}")
    if not all(isinstance(item, (int, float)) for item in items):
        raise RemoteProtocolError(f"something in {str(items)[:60]} is no number")
    values = np.array([float(item) for item in items], np.float64)  # type: ignore[arg-type]
    if not np.isfinite(values).all():
        raise RemoteProtocolError(f"something in {str(items)[:60]} is not finite")
    return values


def joints(items: Item | Sequence[Item], count: int) -> list[int]:
    """Return indices of joints, which must be less than `count`. Raises RemoteProtocolError."""
    indices = [item for item in items if isinstance(item, int)] if isinstance(items, list) else []
    if not indices or items != indices or not all(0 <= index < count for index in indices):
        raise RemoteProtocolError(f"joints are 0 to {count - 1}, not {str(items)[:60]}")
    return indices


def degrees(angles: Vector) -> list[Item]:
    """Convert radians to a list of degrees."""
    return [float(value) for value in np.degrees(angles)]

"""Requests to a robot on YARP, and its answers: control boards and Cartesian controllers."""

from __future__ import annotations

from fuzz._input import Input, refusing
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.servo.robots import teo_messages
from grabbergui.servo.robots.cartesian_messages import read_cartesian_command, read_status


def seeds() -> list[bytes]:
    """Return commands and readings."""
    texts = ("([ivel] [vmos]) (1 2 3)", "(1 2 3) (4 5)", "[get] [encs]", "movl 0.1 0.2 0.3 0 0 1 0.5")
    return [Bottle.from_text(text).encode() for text in texts]


def one_input(data: bytes) -> None:
    """Read a message as each that it could be."""
    bottle = refusing(Bottle.decode, Input(data).rest())
    if bottle is not None:
        refusing(teo_messages.read_board_command, bottle, 6)
        refusing(teo_messages.read_encoders, bottle, 6)
        refusing(read_status, bottle)
        refusing(read_cartesian_command, bottle, "movl")

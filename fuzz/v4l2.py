"""Webcams: any controls and sizes that a driver lists become a description that loads and can be used."""

from __future__ import annotations

from typing import cast

from fuzz._descriptions import Registers
from fuzz._input import Input
from fuzz.description import use
from grabbergui.driver.device import Device
from grabbergui.driver.genapi.cleaning import clean_xml
from grabbergui.driver.genapi.loading import load
from grabbergui.driver.genapi.port import RegisterPort
from grabbergui.driver.v4l2.description import PFNC_NAMES, STANDARD, describe
from grabbergui.driver.v4l2.video import Control, ControlKind, FrameSizes

KNOWN = sorted(STANDARD)
CODES = sorted(PFNC_NAMES)
KINDS = list(ControlKind)


def seeds() -> list[bytes]:
    """Return controls of each kind, known and unknown, and both kinds of sizes."""
    menu = b"\4Auto\0\0\0\1\6Manual\0\0\0\2"
    controls = [
        bytes((kind, known)) + b"\x0bPower Line\0" + bytes(4) + b"\0\0\0\xff" + b"\0\0\0\1" + b"\2" + menu
        for kind in range(len(KINDS))
        for known in (0, 2, 255)
    ]
    sizes = b"\2\2\x80\1\xe0\5\0\2\xd0"
    return [b"\0" * 24 + b"\1\2\3" + sizes + each * 2 for each in controls]


def one_input(data: bytes) -> None:
    """Make, vet and load a device's description, and read and write every node."""
    source = Input(data)
    registers = Registers(source.take(24))
    codes = [CODES[byte % len(CODES)] for byte in source.take(source.number(1) % 4)]
    count = source.number(1) % 4
    sizes = [(source.number(2), source.number(2)) for _ in range(count)]
    limits = FrameSizes.listed(sizes) if count else FrameSizes((), (16, 640, 2), (16, 480, 2))
    controls: list[Control] = []
    while (rest := source.rest()) and len(controls) < 16:
        source = Input(rest)
        controls.append(_control(source))
    layout = describe("a camera", codes, limits, controls)
    nodes = load(clean_xml(layout.xml))
    nodes.connect(RegisterPort(cast(Device, registers)), "Device")
    for value in (0, -(1 << 63), 1.5):
        for node in nodes.nodes:
            use(node, value)
    # A name may be changed to be unique, but no control is missing.
    if len(layout.controls) != len(controls):
        raise AssertionError(layout)


def _control(source: Input) -> Control:
    kind = KINDS[source.number(1) % len(KINDS)]
    known = source.number(1)
    number = KNOWN[known] if known < len(KNOWN) else 0x00990000 + known
    name = _text(source)
    low, high, step = (int.from_bytes(source.take(4), "big", signed=True) for _ in range(3))
    menu = {}
    for _ in range(source.number(1) % 8):
        entry = _text(source)
        menu[int.from_bytes(source.take(4), "big", signed=True)] = entry
    return Control(number, name, kind, low, high, step, menu)


def _text(source: Input) -> str:
    """Return a name as linuxpy decodes it from the driver's bytes."""
    return source.take(source.number(1) % 33).decode("latin-1").split("\0")[0]

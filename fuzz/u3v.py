"""USB3 Vision: every decoder, the answers to a host's requests, and a camera's whole control side."""

from __future__ import annotations

import functools

import numpy as np

from fuzz._input import DATA, Input, joined, refusing
from grabbergui.core.device_text import text_field
from grabbergui.driver.sim.model import CameraModel
from grabbergui.driver.sim.u3v.device import SimulatedU3vDevice
from grabbergui.driver.u3v import gencp
from grabbergui.driver.u3v.block_assembler import BlockAssembler
from grabbergui.driver.u3v.bootstrap import (
    DeviceInfoDescriptor,
    ManifestEntry,
    StreamRequirements,
    split,
)
from grabbergui.driver.u3v.gencp import Event, Packet
from grabbergui.driver.u3v.stream_protocol import Leader, Trailer, TransferPlan, U3vPayloadType

PLAN = TransferPlan(1024, 2048, 1, 1024, 0, 1024)


def seeds() -> list[bytes]:
    """Return one of each message of ours, and the captured ones."""
    leader = Leader(1, U3vPayloadType.IMAGE, 5, 0x01080001, 64, 48, 0, 0).encode()
    trailer = Trailer(1, 0, 64 * 48, 48, 0).encode(U3vPayloadType.IMAGE)
    commands = [
        Packet(gencp.FLAG_ACKNOWLEDGE, gencp.CommandId.READMEM, 1, gencp.read_memory(0, 64)).encode(),
        Packet(gencp.FLAG_ACKNOWLEDGE, gencp.CommandId.WRITEMEM, 2, gencp.write_memory(4, bytes(4))).encode(),
    ]
    decoded = [*commands, leader, trailer, Event(0x9000, 5, b"data").encode(3)]
    captures = [
        bytes.fromhex(line.split()[1])
        for path in sorted((DATA / "u3v").glob("*.txt"))
        for line in path.read_text().splitlines()
        if line[:2] in ("C ", "S ", "D ")
    ]
    return [
        *(b"\0" + message for message in (*decoded, *captures)),
        b"\1" + joined([leader, bytes(2048), bytes(1024), trailer]),
        b"\2" + joined(commands),
        b"\2" + joined([message for message in captures if message[:4] == b"U3VC"]),
    ]


def one_input(data: bytes) -> None:
    """Feed the part that the first byte chooses."""
    source = Input(data)
    (_decode, _assemble, _camera)[source.number(1) % 3](source)


def _decode(source: Input) -> None:
    data = source.rest()
    packet = refusing(Packet.decode, data)
    for content in (data, packet.data if packet is not None else b""):
        for parse in (gencp.parse_read_memory, gencp.parse_write_memory, gencp.parse_reserved_and_value):
            refusing(parse, content)
    for event in refusing(gencp.decode_events, data) or ():
        event.encode(1)
    leader = refusing(Leader.decode, data)
    refusing(Trailer.decode, data, leader.payload_type if leader is not None else U3vPayloadType.IMAGE)
    needs = refusing(StreamRequirements.decode, data)
    plan = refusing(TransferPlan.for_device, needs, 1 << 20) if needs is not None else None
    if plan is not None and plan.payload_space < needs.payload_size:
        raise AssertionError(plan)
    refusing(ManifestEntry.decode, data)
    refusing(DeviceInfoDescriptor.decode, data)
    refusing(DeviceInfoDescriptor.find, data)
    refusing(lambda: list(split(data)))
    text_field(data)


def _assemble(source: Input) -> None:
    assembler = BlockAssembler(PLAN, lambda: np.zeros(5120, np.uint8))
    for message in source.messages():
        request = assembler.next_request()
        length = min(len(message), len(request.view))
        request.view[:length] = np.frombuffer(message, np.uint8, length)
        in_step = assembler.in_step
        block = assembler.complete(request, length)
        valid = block.trailer.valid_payload_size if block is not None and block.trailer is not None else 0
        if block is not None and not 0 <= block.missing <= max(valid, 0):
            raise AssertionError(block)
        if in_step and not assembler.in_step:
            assembler.give_up()


@functools.cache
def _simulated() -> SimulatedU3vDevice:
    return SimulatedU3vDevice(CameraModel())


def _camera(source: Input) -> None:
    # Made once, as it takes long; what registers hold outlives an input.
    camera = _simulated()
    for message in source.messages():
        camera.command(message)
    camera.reset()

"""GVSP: every decoder; the same datagrams must make the same frames one by one and by rows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fuzz._input import Input, captured, joined, refusing
from grabbergui.driver.gige import gvsp
from grabbergui.driver.gige.packet_header import PacketFormat, PacketHeader
from grabbergui.driver.gige.stream.assembler import BlockAssembler
from grabbergui.driver.gige.stream.frame_builder import FrameBuilder
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.enumerations import Compression, FrameContent
from grabbergui.driver.sim.gige.packets import FramePackets
from grabbergui.driver.sim.memory import Register
from grabbergui.driver.sim.model import CameraModel

STRIDES = (8, 64, 540, 1464)
PAYLOAD = 4096


def seeds() -> list[bytes]:
    """Return captured streams, and the datagrams of some for each stride."""
    datagrams = captured("D")
    streams = [datagrams[start : start + 9] for start in range(0, len(datagrams), 9)]
    return [
        *(b"\0" + datagram for datagram in datagrams[:100]),
        *(bytes((1, index % 4, 0)) + joined(stream) for index, stream in enumerate(streams)),
        *(bytes((1, 2, 0)) + joined(_stream(settings)) for settings in _PAYLOADS),
    ]


_PAYLOADS: tuple[dict[Register, float], ...] = (
    {reg.PAYLOAD_TYPE: FrameContent.RAW_DATA},
    {reg.PAYLOAD_TYPE: FrameContent.FILE},
    {reg.PAYLOAD_TYPE: FrameContent.CHUNK_ONLY},
    {reg.IMAGE_COMPRESSION_MODE: Compression.JPEG},
    {reg.IMAGE_COMPRESSION_MODE: Compression.H264},
    dict.fromkeys(reg.COMPONENT_ENABLE, 1),
    {reg.GENDC_STREAMING_MODE: 1},
)


def _stream(power_on: dict[Register, float]) -> list[bytes]:
    """Return the datagrams of a small frame of the simulated camera."""
    size = {reg.WIDTH: 32, reg.HEIGHT: 16, reg.EXPOSURE_TIME: 100.0}
    model = CameraModel(power_on=size | power_on)
    model.write(reg.ACQUISITION_START.address, (1).to_bytes(4, "big"))
    plan = model.next_frame(10.0)
    assert plan is not None
    out = np.zeros(plan.payload_bytes, np.uint8)
    block = FramePackets(plan, out[: model.render(plan, out)], packet_size=576)
    return [block.packet(index) for index in range(block.trailer_id + 1)]


def one_input(data: bytes) -> None:
    """Feed the decoders or the assembler, as the first byte chooses."""
    source = Input(data)
    (_decode, _assemble)[source.number(1) % 2](source)


def _decode(source: Input) -> None:
    datagram = source.rest()
    header = refusing(PacketHeader.decode, datagram)
    if header is None:
        return
    body = datagram[header.size :]
    leader = refusing(gvsp.Leader.decode, body)
    if leader is not None and leader.image_bytes < 0:
        raise AssertionError(leader)
    refusing(gvsp.Trailer.decode, body)
    refusing(gvsp.PartPosition.decode, body)
    refusing(gvsp.GendcPosition.decode, body)


def _assemble(source: Input) -> None:
    stride = STRIDES[source.number(1) % len(STRIDES)]
    incomplete = bool(source.number(1) & 1)
    datagrams = list(source.messages())
    outcomes = [
        _frames(_one_by_one(datagrams, stride, incomplete)),
        _frames(_by_rows(datagrams, stride, incomplete)),
    ]
    # Of a block that goes on behind its announced end it is left open where it ends.
    if outcomes[0] != outcomes[1] and not _goes_on(datagrams, stride):
        raise AssertionError(f"one by one: {outcomes[0]}\nby rows: {outcomes[1]}")


def _goes_on(datagrams: list[bytes], stride: int) -> bool:
    announced: dict[int, int] = {}
    for datagram in datagrams:
        header = refusing(PacketHeader.decode, datagram)
        if header is None:
            continue
        if header.format == PacketFormat.LEADER:
            leader = refusing(gvsp.Leader.decode, datagram[header.size :])
            if leader is not None and leader.payload_bytes is not None:
                announced[header.block_id] = -(-leader.payload_bytes // stride)
        elif header.packet_id > announced.get(header.block_id, header.packet_id):
            return True
    return False


def _assembler(stride: int, incomplete: bool) -> BlockAssembler:
    return BlockAssembler(stride, PAYLOAD, lambda: np.zeros(PAYLOAD, np.uint8), deliver_incomplete=incomplete)


def _one_by_one(datagrams: list[bytes], stride: int, incomplete: bool) -> BlockAssembler:
    assembler = _assembler(stride, incomplete)
    for datagram in datagrams:
        assembler.receive(datagram, 0.0)
    return assembler


def _by_rows(datagrams: list[bytes], stride: int, incomplete: bool) -> BlockAssembler:
    assembler = _assembler(stride, incomplete)
    rows: list[bytes] = []
    for datagram in (*datagrams, b""):
        if rows and len(datagram) != len(rows[0]):
            assembler.receive_rows(_as_rows(rows), 0.0)
            rows = []
        if datagram:
            rows.append(datagram)
        else:
            assembler.receive(b"", 0.0)
    assembler.statistics.packets_ignored -= 1  # the end that was added
    return assembler


def _as_rows(rows: list[bytes]) -> NDArray[np.uint8]:
    return np.frombuffer(b"".join(rows), np.uint8).reshape(len(rows), -1)


def _frames(assembler: BlockAssembler) -> list[object]:
    list(assembler.resend_requests())
    now = 0.0
    for _ in range(1000):
        due = assembler.timer()
        if due == float("inf"):
            break
        now = max(now, due)
        assembler.handle_timer(now)
        list(assembler.resend_requests())
    else:
        raise AssertionError("a block is never given up")
    builder = FrameBuilder(1_000_000_000)
    frames: list[object] = []
    for block in assembler.finished():
        frame = builder.build(block)
        if not 0 <= frame.nbytes <= PAYLOAD:
            raise AssertionError(frame)
        data = b"".join(part.data.tobytes() for part in frame.parts) or frame.payload.tobytes()
        frames.append((frame.frame_id, frame.width, frame.height, frame.status, frame.payload_type, data))
    statistics = assembler.statistics
    return [*frames, statistics.incomplete, statistics.packets_duplicate, statistics.packets_ignored]

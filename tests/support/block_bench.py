"""Datagrams of small images, and an assembler with a clock of its own that takes them."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray

from grabbergui.core.frame import BufferPool
from grabbergui.driver.gige.gvcp import PacketResend
from grabbergui.driver.gige.gvsp import Leader, Trailer
from grabbergui.driver.gige.packet_header import PacketFormat, PacketHeader
from grabbergui.driver.gige.stream.assembler import BlockAssembler
from grabbergui.driver.gige.stream.block import Block
from grabbergui.driver.gige.stream.resend import ResendPolicy

STRIDE = 100
WIDTH, HEIGHT = 64, 24
SIZE = WIDTH * HEIGHT
LAST = -(-SIZE // STRIDE) + 1
"Packet id of the trailer: 16 payload packets, the last of 36 bytes."


def image(block_id: int) -> bytes:
    """Return the pixels of a block, which differ from those of the next ones."""
    return bytes((block_id * 7 + i) % 251 for i in range(SIZE))


def block(
    block_id: int,
    *,
    extended: bool = False,
    data: bytes | None = None,
    payload_type: int = 1,
    height: int = HEIGHT,
    stride: int = STRIDE,
) -> list[bytes]:
    """Return the datagrams of one block: leader, payload packets, trailer."""
    data = image(block_id) if data is None else data
    leader = Leader(payload_type, 1000 * block_id, 0x01080001, WIDTH, HEIGHT)
    pieces = [data[at : at + stride] for at in range(0, len(data), stride)]
    trailer = Trailer(payload_type, height, len(data) if payload_type & 0x4000 else None)

    def packet(kind: PacketFormat, packet_id: int, body: bytes) -> bytes:
        return PacketHeader(kind, block_id, packet_id, extended=extended).encode() + body

    return [
        packet(PacketFormat.LEADER, 0, leader.encode()),
        *(packet(PacketFormat.PAYLOAD, index, piece) for index, piece in enumerate(pieces, 1)),
        packet(PacketFormat.TRAILER, len(pieces) + 1, trailer.encode()),
    ]


class Bench:
    """An assembler with a clock of its own and a pool of buffers."""

    def __init__(
        self, *, payload_size: int = SIZE, stride: int = STRIDE, buffers: int = 8, **options: object
    ) -> None:
        self.pool = BufferPool(payload_size, buffers)
        deliver_incomplete = bool(options.pop("deliver_incomplete", False))
        self.assembler = BlockAssembler(
            stride,
            payload_size,
            self._take,
            ResendPolicy(**options),  # type: ignore[arg-type]
            deliver_incomplete=deliver_incomplete,
        )
        self.statistics = self.assembler.statistics
        self.now = 100_000.0
        "Seconds, as on a machine that has been up for a day."
        self.requests: list[PacketResend] = []

    def _take(self) -> NDArray[np.uint8] | None:
        """Return a buffer with something old in it, the same in each run; None if none is free."""
        buffer = self.pool.take()
        if buffer is not None:
            buffer[:] = 0xAA
        return buffer

    def feed(self, datagrams: Iterable[bytes], period: float = 1e-5) -> list[Block]:
        """Receive datagrams, one every `period` seconds, and return the blocks that are finished."""
        done: list[Block] = []
        for datagram in datagrams:
            self.assembler.receive(datagram, self.now)
            self.now += period
            done += self.tick()
        return done

    def tick(self) -> list[Block]:
        """Let the assembler look at the time, note its requests and return the blocks that are finished."""
        self.assembler.handle_timer(self.now)
        self.requests += self.assembler.resend_requests()
        return list(self.assembler.finished())

    def wait(
        self, seconds: float, answer: Callable[[PacketResend], Iterable[bytes]] | None = None
    ) -> list[Block]:
        """Let time pass; `answer` makes a device's datagrams for each request."""
        end = self.now + seconds
        done = self.tick()
        while True:
            while answer is not None and self.requests:
                done += self.feed(answer(self.requests.pop(0)))
            if self.assembler.timer() > end:
                self.now = max(self.now, end)
                return done
            self.now = max(self.now, self.assembler.timer())
            done += self.tick()


def ids(done: Iterable[Block]) -> list[int]:
    """Return the block ids."""
    return [each.block_id for each in done]


def is_image(done: Block) -> bool:
    """Return whether a block is complete, with the pixels that `image` gives."""
    return done.complete and done.payload.tobytes() == image(done.block_id)


def fuzz_headers() -> st.SearchStrategy[bytes]:
    """Return datagrams with a header that can be read, of whatever ids, format and body."""
    small = st.sampled_from([0, 1, 2, 3, 5, LAST, LAST + 1, 1000, 0xFFFFFF])
    header = st.builds(
        PacketHeader,
        st.integers(0, 9),
        st.sampled_from([0, 1, 2, 3, 4, 9, 200, 65535]),
        small,
        st.sampled_from([0, 0x100, 0x800C, 0x8012]),
        st.booleans(),
    )
    body = st.one_of(
        st.binary(max_size=120),
        st.sampled_from(
            [Leader(1, 0, 0x01080001, WIDTH, HEIGHT).encode(), Trailer(1, HEIGHT).encode(), bytes(100)]
        ),
        st.just(b"\0\0\0\x0a" + bytes(8 + 48)),
    )
    return st.builds(lambda head, data: head.encode() + data, header, body)

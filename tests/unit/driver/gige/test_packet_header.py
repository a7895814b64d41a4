"""Headers of many packets at once, as rows of an array."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from grabbergui.driver.gige.gvcp import Status
from grabbergui.driver.gige.packet_header import (
    FLAG_RESEND,
    PacketFormat,
    PacketHeader,
    count_in_order,
    decode_rows,
)


def header(
    packet_id: int,
    block_id: int = 7,
    *,
    status: int = 0,
    flags: int = 0,
    kind: int = PacketFormat.PAYLOAD,
    extended: bool = False,
) -> bytes:
    return PacketHeader(kind, block_id, packet_id, status, extended, flags).encode()


def rows_of(headers: list[bytes], length: int | None = None) -> NDArray[np.uint8]:
    """Return headers as rows, each filled up to `length` with bytes that are no header."""
    padded = [each.ljust(length or len(each), b"\xff") for each in headers]
    return np.array([list(each) for each in padded], np.uint8)


EACH = pytest.mark.parametrize("extended", [False, True], ids=["standard", "extended"])


@EACH
@pytest.mark.parametrize("length", [None, 28])
def test_consecutive_packets_of_one_block_are_in_order(extended: bool, length: int | None) -> None:
    for count in (1, 2, 5):
        rows = rows_of([header(packet_id, extended=extended) for packet_id in range(3, 3 + count)], length)
        assert count_in_order(rows) == count


@EACH
@pytest.mark.parametrize(
    "breaking",
    [
        {"packet_id": 7},
        {"packet_id": 5},
        {"packet_id": 4},
        {"block_id": 8},
        {"kind": PacketFormat.TRAILER},
        {"status": Status.PACKET_UNAVAILABLE},
        {"status": Status.PACKET_RESEND},
    ],
    ids=str,
)
def test_the_order_ends_with_a_gap_a_repetition_or_another_kind(
    extended: bool, breaking: dict[str, int]
) -> None:
    follower = header(**{"packet_id": 6, **breaking}, extended=extended)
    before = [header(packet_id, extended=extended) for packet_id in (3, 4, 5)]
    assert count_in_order(rows_of([*before, follower, header(9)], 20)) == 3
    assert count_in_order(rows_of([follower, follower], 20)) == (breaking != {"status": 0x100})


@EACH
def test_a_resent_packet_begins_no_order(extended: bool) -> None:
    resent = header(3, status=Status.PACKET_RESEND, extended=extended)
    assert count_in_order(rows_of([resent, header(4, extended=extended)], 20)) == 0
    assert count_in_order(rows_of([header(2, extended=extended), resent], 20)) == 1


def test_a_flag_marks_resent_packets_of_extended_headers_only() -> None:
    flagged = header(3, flags=FLAG_RESEND, extended=True)
    assert count_in_order(rows_of([flagged, header(4, extended=True)])) == 0
    assert count_in_order(rows_of([header(2, extended=True), flagged])) == 1
    # The same bits are the lowest of a standard header's block id.
    assert count_in_order(rows_of([header(3, block_id=1), header(4, block_id=1)])) == 2


def test_extended_headers_that_are_cut_off_are_in_no_order() -> None:
    rows = rows_of([header(packet_id, extended=True)[:19] for packet_id in (1, 2)])
    assert count_in_order(rows) == 0


def test_block_ids_of_64_bits_are_told_apart() -> None:
    highest = (1 << 64) - 1
    rows = rows_of([header(1, highest - 1, extended=True), header(2, highest, extended=True)])
    assert count_in_order(rows) == 1
    assert decode_rows(rows)[2].tolist() == [True]


@EACH
def test_rows_have_packet_ids_marks_and_bounds(extended: bool) -> None:
    headers = [
        header(1, extended=extended),
        header(5, extended=extended, status=Status.PACKET_RESEND),
        header(2, extended=extended),
        header(3, block_id=8, extended=extended),
        header(4, block_id=8, extended=extended, kind=PacketFormat.TRAILER),
        header(0xFFFFFF, block_id=8, extended=extended, kind=PacketFormat.TRAILER),
    ]
    ids, resent, differs = decode_rows(rows_of(headers, 24))
    assert ids.tolist() == [1, 5, 2, 3, 4, 0xFFFFFF]
    assert resent.tolist() == [False, True, False, False, False, False]
    assert differs.tolist() == [False, False, True, True, False]


def test_rows_of_both_kinds_are_read_each_by_its_own_layout() -> None:
    headers = [
        header(1, block_id=1),
        header(2, block_id=1),
        header(1 << 24, block_id=1, extended=True),
        header(2, block_id=1, extended=True, flags=FLAG_RESEND),
        header(2, block_id=1 << 40, extended=True),
        header(3, block_id=1),
    ]
    ids, resent, differs = decode_rows(rows_of(headers, 24))
    assert ids.tolist() == [1, 2, 1 << 24, 2, 2, 3]
    assert resent.tolist() == [False, False, False, True, False, False]
    assert differs.tolist() == [False, True, False, True, True]


def test_extended_headers_that_are_cut_off_are_each_apart() -> None:
    cut = [header(packet_id, extended=True)[:8] for packet_id in (1, 2)]
    assert decode_rows(rows_of([header(1), header(2), *cut]))[2].tolist() == [False, True, True]
    assert decode_rows(rows_of([header(1, 7), header(1, 8), cut[0]]))[2].tolist() == [True, True]

from __future__ import annotations

import contextlib
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from every_case import every_case
from grabbergui.core.errors import RemoteProtocolError
from grabbergui.driver.u3v.bootstrap import ManifestEntry, StreamRequirements, descriptions
from grabbergui.driver.u3v.stream_protocol import (
    Leader,
    Trailer,
    TransferPlan,
    U3vPayloadType,
    is_leader,
    is_trailer,
)
from u3v_bench import records, transcripts

STREAMS = [name for name in transcripts() if name.startswith("stream")]


@pytest.mark.parametrize("name", STREAMS)
def test_recorded_blocks_are_read_and_written_back(name: str) -> None:
    transfers = records(name, "D")
    leaders = [Leader.decode(transfer) for transfer in transfers if is_leader(transfer)]
    trailers = [transfer for transfer in transfers if is_trailer(transfer)]
    assert leaders
    for leader, transfer in zip(leaders, filter(is_leader, transfers), strict=True):
        assert leader.payload_type == U3vPayloadType.IMAGE
        assert (leader.size_x, leader.size_y) in ((64, 48), (70, 50))
        assert leader.pixel_format == 0x01080001
        assert leader.encode(len(transfer)) == transfer
    for transfer in trailers:
        trailer = Trailer.decode(transfer, U3vPayloadType.IMAGE)
        assert trailer.valid_payload_size in (3072, 3500)
        assert trailer.size_y in (48, 50)
        fields = trailer.encode(U3vPayloadType.IMAGE)
        assert transfer.startswith(fields[:6])
        assert transfer[8:32] == fields[8:32]


def test_chunk_blocks_have_no_geometry() -> None:
    leader = Leader(7, U3vPayloadType.CHUNK, 99)
    assert len(leader.encode()) == 28
    assert Leader.decode(leader.encode()) == leader
    trailer = Trailer(7, 0, 1000, None, 5)
    assert Trailer.decode(trailer.encode(U3vPayloadType.CHUNK), U3vPayloadType.CHUNK) == trailer


def test_an_extended_chunk_trailer_has_height_and_layout() -> None:
    trailer = Trailer(7, 0xA100, 1000, 33, 5)
    data = trailer.encode(U3vPayloadType.IMAGE_EXTENDED_CHUNK)
    assert len(data) == 36
    assert Trailer.decode(data, U3vPayloadType.IMAGE_EXTENDED_CHUNK) == trailer


@every_case("length", range(52))
def test_a_cut_leader_is_refused(length: int) -> None:
    data = Leader(1, U3vPayloadType.IMAGE, 2, 3, 4, 5).encode()
    with pytest.raises(RemoteProtocolError):
        Leader.decode(data[:length])


@given(
    st.sampled_from([b"", b"U3VL", b"U3VT"]), st.binary(max_size=80), st.sampled_from(list(U3vPayloadType))
)
def test_any_bytes_give_a_value_or_an_error_of_the_protocol(
    prefix: bytes, rest: bytes, kind: U3vPayloadType
) -> None:
    data = prefix + rest
    for codec in (Leader, TransferPlan, StreamRequirements, ManifestEntry):
        with contextlib.suppress(RemoteProtocolError):
            value = codec.decode(data)
            assert codec.decode(value.encode()) == value
    with contextlib.suppress(RemoteProtocolError):
        trailer = Trailer.decode(data, kind)
        again = Trailer.decode(trailer.encode(kind), kind)
        # Where there was no room for the height, ours has room and says 0.
        size_y = None if kind is U3vPayloadType.CHUNK else trailer.size_y or 0
        assert again == replace(trailer, size_y=size_y)


@given(
    payload=st.integers(1, 1 << 26),
    exponent=st.integers(0, 12),
    largest=st.integers(1024, 1 << 22),
    packet=st.sampled_from((512, 1024)),
)
def test_a_plan_covers_the_payload_in_aligned_transfers(
    payload: int, exponent: int, largest: int, packet: int
) -> None:
    needs = StreamRequirements(1 << exponent, False, payload, 52, 32)
    plan = TransferPlan.for_device(needs, largest, packet)
    assert plan.payload_space >= payload
    assert plan.payload_space - payload < needs.alignment + (plan.transfer_size if not plan.final_1 else 0)
    assert all(size % needs.alignment == 0 for size in plan.payload_sizes)
    assert plan.transfer_size % packet == 0
    assert plan.transfer_size <= max(largest, needs.alignment, packet)
    assert plan.leader_size >= 52
    assert TransferPlan.decode(plan.encode()) == plan


def test_the_plan_is_the_one_that_another_host_makes() -> None:
    """As in stream_viva_70x50_mono8.txt: 3500 bytes in transfers of 3072 and 428."""
    plan = TransferPlan.for_device(StreamRequirements(1, False, 3500, 52, 36), 1 << 20)
    assert plan.payload_sizes == [3072, 428]


@pytest.mark.parametrize("payload", [0, (1 << 29) + 1, (1 << 64) - 1])
def test_an_absurd_payload_is_refused(payload: int) -> None:
    with pytest.raises(RemoteProtocolError, match="announces a payload"):
        TransferPlan.for_device(StreamRequirements(1, False, payload, 52, 36), 1 << 20)


@pytest.mark.parametrize(("leader", "trailer"), [((1 << 20) + 1, 36), (52, (1 << 32) - 1)])
def test_an_absurd_leader_or_trailer_is_refused(leader: int, trailer: int) -> None:
    needs = StreamRequirements(1, False, 3500, leader, trailer)
    with pytest.raises(RemoteProtocolError, match=f"leader of {leader} bytes and a trailer of {trailer}"):
        TransferPlan.for_device(needs, 1 << 20)


def test_an_absurd_alignment_is_refused() -> None:
    with pytest.raises(RemoteProtocolError, match=r"aligned to 2\^40"):
        StreamRequirements.decode(bytes((0, 0, 0, 40)) + bytes(20))


@pytest.mark.parametrize("name", [name for name in STREAMS if "viva" not in name])
def test_the_recorded_manifest_leads_to_the_description(name: str) -> None:
    raw = next(
        data[12:] for data in records(name, "S") if len(data) == 12 + 64 and data[12:16] == b"\0\0\0\1"
    )
    entry = ManifestEntry.decode(raw)
    assert entry.version == (1, 0, 0)
    assert entry.schema == (1, 1)
    assert (entry.file_type, entry.file_format) == (0, 0)
    assert entry.address == 0x100000
    assert entry.encode() == raw
    assert descriptions([entry]) == [entry]

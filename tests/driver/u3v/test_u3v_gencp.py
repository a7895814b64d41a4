from __future__ import annotations

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st
from u3v_bench import records, transcripts

from grabbergui.core.errors import LocalProtocolError, RemoteProtocolError
from grabbergui.driver.u3v import gencp
from grabbergui.driver.u3v.gencp import CommandId, Event, Packet, decode_events

READ = Packet(0x4000, CommandId.READMEM, 0xFF15, gencp.read_memory(0x04, 64))

u16 = st.integers(0, 0xFFFF)

GOLDEN = [  # from control_open_read_write.txt
    (READ, "55335643004000080c0015ff040000000000000000004000"),
    (
        Packet(0, CommandId.READMEM_ACK, 0xFF16, (0x10000).to_bytes(8, "little")),
        "5533564300000108080016ff0000010000000000",
    ),
]


@pytest.mark.parametrize(("packet", "hexadecimal"), GOLDEN)
def test_packets_are_those_of_a_real_host(packet: Packet, hexadecimal: str) -> None:
    assert packet.encode().hex() == hexadecimal
    assert Packet.decode(bytes.fromhex(hexadecimal)) == packet


@pytest.mark.parametrize("name", transcripts())
def test_every_recorded_packet_is_read_and_written_back(name: str) -> None:
    commands, answers = records(name, "C"), records(name, "S")
    assert commands
    assert len(commands) == len(answers)
    for command, answer in zip(map(Packet.decode, commands), map(Packet.decode, answers), strict=True):
        assert answer.request_id == command.request_id
        assert answer.command == command.command + 1
        if command.command == CommandId.READMEM:
            address, length = gencp.parse_read_memory(command.data)
            assert gencp.read_memory(address, length) == command.data
            assert len(answer.data) == length
        else:
            address, data = gencp.parse_write_memory(command.data)
            assert gencp.write_memory(address, data) == command.data
            assert gencp.parse_reserved_and_value(answer.data) == len(data)
    for transfer in commands + answers:
        assert Packet.decode(transfer).encode() == transfer


@pytest.mark.parametrize("length", range(len(READ.encode())))
def test_a_cut_packet_is_refused(length: int) -> None:
    with pytest.raises(RemoteProtocolError):
        Packet.decode(READ.encode()[:length])


def test_an_overlong_packet_is_refused() -> None:
    with pytest.raises(RemoteProtocolError, match="announces 12 bytes of data and has 13"):
        Packet.decode(READ.encode() + b"x")


@st.composite
def transfers(draw: st.DrawFn) -> bytes:
    """Any bytes, or any behind a header that may be right."""
    data = draw(st.binary(max_size=60))
    if draw(st.booleans()):
        return data
    prefix = draw(st.sampled_from([gencp.PREFIX, gencp.EVENT_PREFIX]))
    command = draw(st.sampled_from([CommandId.READMEM, CommandId.EVENT]))
    length = len(data) + draw(st.sampled_from([0, 0, 0, 1]))
    return Packet.HEADER.pack(prefix, draw(u16), command, length, draw(u16)) + data


@given(transfers())
def test_any_bytes_are_the_packet_they_give_or_an_error_of_the_protocol(data: bytes) -> None:
    with contextlib.suppress(RemoteProtocolError):
        assert Packet.decode(data).encode() == data


@given(transfers())
def test_any_bytes_give_events_of_as_many_bytes_or_an_error_of_the_protocol(data: bytes) -> None:
    with contextlib.suppress(RemoteProtocolError):
        sizes = [Event.RECORD.size + len(event.data) for event in decode_events(data)]
        assert gencp.HEADER_SIZE + sum(sizes) == len(data)


@given(st.binary(max_size=20))
def test_any_bytes_are_a_commands_data_or_an_error_of_the_protocol(data: bytes) -> None:
    with contextlib.suppress(RemoteProtocolError):
        written = gencp.read_memory(*gencp.parse_read_memory(data))
        assert written[:8] + written[10:] == data[:8] + data[10:]  # two bytes are reserved
    with contextlib.suppress(RemoteProtocolError):
        assert gencp.write_memory(*gencp.parse_write_memory(data)) == data


@given(
    st.lists(st.tuples(st.integers(0, 0xFFFF), st.integers(0, 2**64 - 1), st.binary(max_size=40)), min_size=1)
)
def test_events_of_a_multi_event_packet_come_apart(fields: list[tuple[int, int, bytes]]) -> None:
    events = [Event(*field) for field in fields]
    records_ = b"".join(event.encode(0, multi_event=True)[gencp.HEADER_SIZE :] for event in events)
    packet = Packet.HEADER.pack(gencp.EVENT_PREFIX, 0, CommandId.EVENT, len(records_), 7) + records_
    assert decode_events(packet) == events


def test_a_single_event_takes_the_rest_of_its_packet() -> None:
    event = Event(0x9001, 123, b"abc")
    assert decode_events(event.encode(5)) == [event]


def test_an_event_longer_than_its_packet_is_refused() -> None:
    packet = bytearray(Event(1, 2, b"data").encode(1, multi_event=True))
    packet[gencp.HEADER_SIZE] += 1
    with pytest.raises(RemoteProtocolError, match="says it has 17 bytes; 16 are left"):
        decode_events(bytes(packet))


def test_what_does_not_fit_is_our_own_error() -> None:
    for bad in (
        lambda: gencp.read_memory(-1, 4),
        lambda: gencp.read_memory(0, 1 << 16),
        lambda: gencp.write_memory(1 << 64, b""),
        lambda: Packet(0, CommandId.READMEM, 1 << 16).encode(),
    ):
        with pytest.raises(LocalProtocolError):
            bad()


@pytest.mark.parametrize(
    ("status", "text"),
    [
        (0x8003, "0x8003 (invalid address)"),
        (0xA004, "0xA004 (stream registers inconsistent)"),
        (0xC001, "0xC001 (unknown vendor status)"),
    ],
)
def test_a_status_has_display_text(status: int, text: str) -> None:
    assert gencp.status_text(status) == text

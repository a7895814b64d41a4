from __future__ import annotations

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from every_case import every_case
from grabbergui.core.errors import AckTimeoutError, DeviceStatusError, LocalProtocolError, RemoteProtocolError
from grabbergui.driver.u3v import gencp
from grabbergui.driver.u3v.control_channel import BUSY_PAUSE, LONGEST_PENDING, TRIES, ControlChannel
from grabbergui.driver.u3v.gencp import CommandId, Event, Packet, decode_events
from u3v_bench import records, transcripts

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


@every_case("length", range(len(READ.encode())))
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
    with pytest.raises(RemoteProtocolError, match="announces 17 bytes; 16 are left"):
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


ADDRESS_AND_LENGTH = gencp.read_memory(0x1D0, 8)


def answer(transfer: bytes, data: bytes = b"12345678", status: int = 0) -> bytes:
    command = Packet.decode(transfer)
    return Packet(status, command.command + 1, command.request_id, data).encode()


def pending(transfer: bytes, milliseconds: int) -> bytes:
    request_id = Packet.decode(transfer).request_id
    return Packet(0, CommandId.PENDING_ACK, request_id, gencp.reserved_and_value(milliseconds)).encode()


def test_an_answer_ends_the_command() -> None:
    channel = ControlChannel()
    got = channel.receive(answer(channel.begin(CommandId.READMEM, ADDRESS_AND_LENGTH, 0.0)), 0.01)
    assert got is not None
    assert got.data == b"12345678"
    channel.begin(CommandId.READMEM, ADDRESS_AND_LENGTH, 0.02)


def test_one_command_at_a_time() -> None:
    channel = ControlChannel()
    channel.begin(CommandId.READMEM, ADDRESS_AND_LENGTH, 0.0)
    with pytest.raises(LocalProtocolError):
        channel.begin(CommandId.READMEM, ADDRESS_AND_LENGTH, 0.0)


def test_a_lost_command_is_sent_again_with_a_new_id_and_then_given_up() -> None:
    channel = ControlChannel()
    first = channel.begin(CommandId.READMEM, ADDRESS_AND_LENGTH, 0.0)
    assert channel.deadline == channel.response_time
    again = channel.expire(0.5)
    assert Packet.decode(again).request_id != Packet.decode(first).request_id
    assert channel.receive(answer(first), 0.6) is None, "a late answer to the first try"
    for _ in range(TRIES - 2):
        channel.expire(1.0)
    with pytest.raises(AckTimeoutError, match=f"after {TRIES} tries"):
        channel.expire(1.5)
    channel.begin(CommandId.READMEM, ADDRESS_AND_LENGTH, 9.0)


def test_a_program_that_was_held_up_waits_for_the_answer_to_each_try() -> None:
    channel = ControlChannel()
    channel.begin(CommandId.READMEM, ADDRESS_AND_LENGTH, 0.0)
    again = channel.expire(3.0)
    assert channel.deadline == 3.0 + channel.response_time
    assert channel.receive(answer(again), 3.1) is not None


def test_a_pending_acknowledge_moves_the_deadline_but_not_for_ever() -> None:
    channel = ControlChannel()
    transfer = channel.begin(CommandId.WRITEMEM, ADDRESS_AND_LENGTH, 0.0)
    assert channel.receive(pending(transfer, 700), 0.1) is None
    assert channel.deadline == pytest.approx(0.1 + 0.7 + channel.response_time)
    now = 0.1
    while now < LONGEST_PENDING:
        channel.receive(pending(transfer, 60_000), now)
        now += 10
    assert channel.deadline == LONGEST_PENDING
    with pytest.raises(AckTimeoutError, match="within 60 s; the camera had asked for more time"):
        channel.expire(LONGEST_PENDING)
    transfer = channel.begin(CommandId.READMEM, ADDRESS_AND_LENGTH, 100.0)
    channel.receive(pending(transfer, 60_000), 100.0)
    assert channel.deadline == 100 + 4 * channel.response_time, "the next may not be postponed as long again"
    channel.receive(answer(transfer, bytes(4)), 101.0)
    transfer = channel.begin(CommandId.READMEM, ADDRESS_AND_LENGTH, 200.0)
    channel.receive(pending(transfer, 60_000), 200.0)
    assert channel.deadline == 200 + LONGEST_PENDING


def test_a_refusal_names_address_and_status() -> None:
    channel = ControlChannel()
    transfer = channel.begin(CommandId.READMEM, ADDRESS_AND_LENGTH, 0.0)
    with pytest.raises(DeviceStatusError, match=r"READMEM at 0x1D0: 0x8003 \(invalid address\)") as caught:
        channel.receive(answer(transfer, b"", 0x8003), 0.0)
    assert caught.value.status == 0x8003
    channel.begin(CommandId.READMEM, ADDRESS_AND_LENGTH, 0.0)


def test_a_busy_device_is_asked_again_before_it_is_believed() -> None:
    channel = ControlChannel()
    transfer = channel.begin(CommandId.READMEM, ADDRESS_AND_LENGTH, 0.0)
    for _ in range(TRIES - 1):
        assert channel.receive(answer(transfer, b"", gencp.Status.BUSY), 0.1) is None
        assert channel.deadline == pytest.approx(0.1 + BUSY_PAUSE)
        transfer = channel.expire(0.2)
    with pytest.raises(DeviceStatusError, match="busy"):
        channel.receive(answer(transfer, b"", gencp.Status.BUSY), 0.1)


def test_foreign_answers_are_dropped_and_counted() -> None:
    channel = ControlChannel()
    transfer = channel.begin(CommandId.READMEM, ADDRESS_AND_LENGTH, 0.0)
    good = answer(transfer)
    wrong_id = Packet(0, CommandId.READMEM_ACK, 999).encode()
    wrong_kind = Packet(0, CommandId.WRITEMEM_ACK, Packet.decode(transfer).request_id).encode()
    for bad in (b"", good[:-1], good + b"x", b"X" + good[1:], wrong_id, wrong_kind):
        assert channel.receive(bad, 0.0) is None
    assert channel.ignored == 6
    assert channel.receive(good, 0.0) is not None


def test_request_ids_skip_zero() -> None:
    channel = ControlChannel(first_request_id=0xFFFF)
    ids = []
    for _ in range(2):
        ids.append(Packet.decode(channel.begin(CommandId.READMEM, ADDRESS_AND_LENGTH, 0.0)).request_id)
        channel.abandon()
    assert ids == [0xFFFF, 1]


@given(st.lists(st.binary(max_size=40)))
def test_noise_never_answers_a_command(noise: list[bytes]) -> None:
    channel = ControlChannel()
    channel.begin(CommandId.READMEM, ADDRESS_AND_LENGTH, 0.0)
    for transfer in noise:
        assert channel.receive(transfer, 0.0) is None

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grabbergui.core.errors import AckTimeoutError, DeviceStatusError, LocalProtocolError
from grabbergui.driver.u3v import gencp
from grabbergui.driver.u3v.control_channel import BUSY_PAUSE, LONGEST_PENDING, TRIES, ControlChannel
from grabbergui.driver.u3v.gencp import CommandId, Packet

READ = gencp.read_memory(0x1D0, 8)


def answer(transfer: bytes, data: bytes = b"12345678", status: int = 0) -> bytes:
    command = Packet.decode(transfer)
    return Packet(status, command.command + 1, command.request_id, data).encode()


def pending(transfer: bytes, milliseconds: int) -> bytes:
    request_id = Packet.decode(transfer).request_id
    return Packet(0, CommandId.PENDING_ACK, request_id, gencp.reserved_and_value(milliseconds)).encode()


def test_an_answer_ends_the_command() -> None:
    channel = ControlChannel()
    got = channel.receive(answer(channel.begin(CommandId.READMEM, READ, 0.0)), 0.01)
    assert got is not None
    assert got.data == b"12345678"
    channel.begin(CommandId.READMEM, READ, 0.02)


def test_one_command_at_a_time() -> None:
    channel = ControlChannel()
    channel.begin(CommandId.READMEM, READ, 0.0)
    with pytest.raises(LocalProtocolError):
        channel.begin(CommandId.READMEM, READ, 0.0)


def test_a_lost_command_is_sent_again_with_a_new_id_and_then_given_up() -> None:
    channel = ControlChannel()
    first = channel.begin(CommandId.READMEM, READ, 0.0)
    assert channel.deadline == channel.response_time
    again = channel.expire()
    assert Packet.decode(again).request_id != Packet.decode(first).request_id
    assert channel.receive(answer(first), 0.6) is None, "a late answer to the first try"
    for _ in range(TRIES - 2):
        channel.expire()
    with pytest.raises(AckTimeoutError, match=f"after {TRIES} tries"):
        channel.expire()
    channel.begin(CommandId.READMEM, READ, 9.0)


def test_a_pending_acknowledge_moves_the_deadline_but_not_for_ever() -> None:
    channel = ControlChannel()
    transfer = channel.begin(CommandId.WRITEMEM, READ, 0.0)
    assert channel.receive(pending(transfer, 700), 0.1) is None
    assert channel.deadline == pytest.approx(0.1 + 0.7 + channel.response_time)
    now = 0.1
    while now < LONGEST_PENDING:
        channel.receive(pending(transfer, 60_000), now)
        now += 10
    assert channel.deadline == LONGEST_PENDING


def test_a_refusal_names_address_and_status() -> None:
    channel = ControlChannel()
    transfer = channel.begin(CommandId.READMEM, READ, 0.0)
    with pytest.raises(DeviceStatusError, match=r"READMEM at 0x1D0: 0x8003 \(invalid address\)") as caught:
        channel.receive(answer(transfer, b"", 0x8003), 0.0)
    assert caught.value.status == 0x8003
    channel.begin(CommandId.READMEM, READ, 0.0)


def test_a_busy_device_is_asked_again_before_it_is_believed() -> None:
    channel = ControlChannel()
    transfer = channel.begin(CommandId.READMEM, READ, 0.0)
    for _ in range(TRIES - 1):
        assert channel.receive(answer(transfer, b"", gencp.Status.BUSY), 0.1) is None
        assert channel.deadline == pytest.approx(0.1 + BUSY_PAUSE)
        transfer = channel.expire()
    with pytest.raises(DeviceStatusError, match="busy"):
        channel.receive(answer(transfer, b"", gencp.Status.BUSY), 0.1)


def test_foreign_answers_are_dropped_and_counted() -> None:
    channel = ControlChannel()
    transfer = channel.begin(CommandId.READMEM, READ, 0.0)
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
        ids.append(Packet.decode(channel.begin(CommandId.READMEM, READ, 0.0)).request_id)
        channel.abandon()
    assert ids == [0xFFFF, 1]


@given(st.lists(st.binary(max_size=40)))
def test_noise_never_answers_a_command(noise: list[bytes]) -> None:
    channel = ControlChannel()
    channel.begin(CommandId.READMEM, READ, 0.0)
    for transfer in noise:
        assert channel.receive(transfer, 0.0) is None

"""The control protocol's codec against captured conversations, both ways."""

from __future__ import annotations

import pytest
from gige_transcripts import CAPTURES, NAMES, lines
from hypothesis import given
from hypothesis import strategies as st

from grabbergui.core.errors import LocalProtocolError, RemoteProtocolError
from grabbergui.driver.gige import gvcp
from grabbergui.driver.gige.gvcp import (
    Ack,
    CommandCode,
    PacketResend,
    ReadMem,
    ReadReg,
    Status,
    WriteMem,
    WriteReg,
)
from grabbergui.driver.gige.gvcp_messages import ForceIp, Identity, encode_discovery, parse_mac

REQUESTS = {message.CODE: message for message in (ReadReg, WriteReg, ReadMem, WriteMem)}


@pytest.mark.parametrize("name", CAPTURES)
def test_captured_commands_are_read_and_written_byte_by_byte(name: str) -> None:
    for line in lines(name, "C"):
        header, payload = gvcp.split_command(line.data)
        if header.command in REQUESTS:
            message = REQUESTS[CommandCode(header.command)].decode(payload)
            again = gvcp.encode_command(message.CODE, message.payload(), header.req_id, header.flags)
        elif header.command == CommandCode.PACKETRESEND:
            again = PacketResend.decode(payload, header.flags).encode(header.req_id)
        elif header.command == CommandCode.DISCOVERY:
            broadcast = bool(header.flags & gvcp.FLAG_BROADCAST_ACK)
            again = encode_discovery(header.req_id, allow_broadcast_ack=broadcast)
        elif header.command == CommandCode.FORCEIP:
            again = ForceIp.decode(payload).encode(header.req_id)
        else:
            assert header.command == CommandCode.ACTION
            continue
        assert again == line.data


@pytest.mark.parametrize("name", NAMES)
def test_captured_acks_answer_their_commands(name: str) -> None:
    asked: dict[tuple[str, int], bytes] = {}
    seen = 0
    for line in lines(name, "CS"):
        if line.kind == "C":
            asked[line.peer, int.from_bytes(line.data[6:8], "big")] = line.data
            continue
        ack = Ack.decode(line.data)
        assert ack.encode() == line.data
        command = asked[line.peer, ack.ack_id]
        code, payload = int.from_bytes(command[2:4], "big"), command[8:]
        seen += 1
        if ack.acknowledge == gvcp.PENDING_ACK:
            assert gvcp.decode_pending_ack(ack.payload) == 1.8
            assert gvcp.encode_pending_ack(1800, ack.ack_id) == line.data
            continue
        assert ack.acknowledge == code + 1
        if ack.failed or name == "probe-aravis":  # which answers only the first register of several
            continue
        if code == CommandCode.READREG:
            values = ReadReg.decode(payload).decode_ack(ack.payload)
            assert ReadReg.encode_ack(values) == ack.payload
        elif code == CommandCode.READMEM:
            request = ReadMem.decode(payload)
            assert ReadMem.encode_ack(request.address, request.decode_ack(ack.payload)) == ack.payload
        elif code == CommandCode.DISCOVERY:
            assert Identity.decode(ack.payload).encode() == ack.payload
    assert seen or name == "viva-action"


def test_an_identity_says_who_it_is() -> None:
    acks = [Ack.decode(line.data) for line in lines("viva-discovery-broadcast", "S")]
    identity = Identity.decode(acks[0].payload)
    assert (identity.mac, identity.ip, identity.spec_version) == ("de:ad:be:ef:ca:fe", "0.0.0.0", (2, 0))
    assert identity.vendor and identity.model and identity.serial


def test_a_refusal_is_read_without_payload() -> None:
    refused = [Ack.decode(line.data) for line in lines("viva-second-host-refused", "S")]
    denied = [ack for ack in refused if ack.failed]
    assert denied and {ack.status for ack in denied} == {Status.ACCESS_DENIED}
    assert gvcp.status_text(denied[0].status) == "ACCESS_DENIED (0x8006)"
    assert gvcp.status_text(0x9999) == "status 0x9999"


@pytest.mark.parametrize(
    "name", ["aravis-open-heartbeat-xml", "viva-resend", "viva-forceip", "viva-pending-ack"]
)
def test_truncated_messages_are_refused_at_every_length(name: str) -> None:
    for line in list(lines(name, "CS"))[:40]:
        for length in range(len(line.data)):
            with pytest.raises(RemoteProtocolError):
                if line.kind == "C":
                    gvcp.split_command(line.data[:length])
                else:
                    Ack.decode(line.data[:length])


def test_bytes_beyond_the_announced_length_are_refused_in_commands_and_cut_off_in_acks() -> None:
    command = gvcp.encode_command(CommandCode.READREG, bytes(4), 7)
    assert gvcp.split_command(command)[1] == bytes(4)
    with pytest.raises(RemoteProtocolError, match="announces 4 bytes, 8 arrived"):
        gvcp.split_command(command + bytes(4))
    ack = Ack(0, CommandCode.READREG + 1, 7, b"\x01\x02\x03\x04")
    # Some devices pad to the shortest Ethernet frame.
    assert Ack.decode(ack.encode() + b"\xff" * 6) == ack


@pytest.mark.parametrize("message", [ReadReg((4,)), ReadMem(0, 8)])
def test_acks_of_the_wrong_size_are_refused(message: ReadReg | ReadMem) -> None:
    for length in (0, 1, 3, 5, 8, 16):
        with pytest.raises(RemoteProtocolError):
            message.decode_ack(bytes(length))
    with pytest.raises(RemoteProtocolError):
        Identity.decode(bytes(247))


def test_illegal_commands_are_never_sent() -> None:
    for build in (
        lambda: ReadReg(()).payload(),
        lambda: ReadReg((0,) * 136).payload(),
        lambda: WriteReg(((0, 0),) * 68).payload(),
        lambda: ReadMem(2, 4).payload(),
        lambda: ReadMem(0, 540).payload(),
        lambda: WriteMem(0, b"abc").payload(),
        lambda: gvcp.encode_command(CommandCode.READREG, bytes(4), 0),
        lambda: gvcp.encode_command(CommandCode.READREG, bytes(600), 1),
        lambda: ForceIp("00:11", "10.0.0.1").encode(1),
        lambda: ForceIp("00:11:22:33:44:55", "10.0.0.256").encode(1),
    ):
        with pytest.raises(LocalProtocolError):
            build()


def test_extended_resend_has_the_block_id_at_its_end() -> None:
    """The Aravis host's own bytes for packet 3 of block 0x100000002."""
    line, *_ = [line for line in lines("accept-extended-ids", "C") if line.data[2:4] == b"\0\x40"]
    header, payload = gvcp.split_command(line.data)
    assert PacketResend.decode(payload, header.flags) == PacketResend(0x100000002, 3, 3, extended=True)


def test_mac_addresses_in_every_spelling() -> None:
    for text in ("00:30:53:0a:0b:0c", "00-30-53-0A-0B-0C", "0030530a0b0c"):
        assert parse_mac(text) == b"\x00\x30\x53\x0a\x0b\x0c"
    with pytest.raises(ValueError, match="no MAC"):
        parse_mac("00:30:53")


@given(st.binary(max_size=600), st.integers(0, 255))
def test_no_datagram_crashes_a_parser(data: bytes, flags: int) -> None:
    parsers = [Ack.decode, gvcp.split_command, gvcp.decode_pending_ack, Identity.decode, ForceIp.decode]
    parsers += [message.decode for message in REQUESTS.values()]
    parsers += [lambda payload: PacketResend.decode(payload, flags)]
    for parse in parsers:
        try:
            parse(data)
        except RemoteProtocolError as error:
            assert str(error)


@given(st.binary(min_size=248, max_size=300))
def test_any_identity_is_text(data: bytes) -> None:
    identity = Identity.decode(data)
    assert all(
        text.isprintable() and text == text.strip()
        for text in (identity.vendor, identity.model, identity.serial, identity.user_name)
    )

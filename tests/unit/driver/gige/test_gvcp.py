"""The control protocol's codec against captured conversations, both ways."""

from __future__ import annotations

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from every_case import every_case
from gige_transcripts import CAPTURES, NAMES, lines
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
from grabbergui.driver.gige.identity import ForceIp, Identity, encode_discovery

REQUESTS = {message.CODE: message for message in (ReadReg, WriteReg, ReadMem, WriteMem)}


@every_case("name", CAPTURES)
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


@every_case("name", NAMES)
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
            assert struct.pack(f">{len(values)}I", *values) == ack.payload
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
    assert gvcp.status_text(0x9999) == "status 0x9999, which this program does not know"
    assert "its maker defines" in gvcp.status_text(0xC001)


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
    for build, reason in (
        (lambda: ReadReg(()).payload(), "of 0 registers"),
        (lambda: ReadReg((0,) * 136).payload(), "of 136 registers"),
        (lambda: WriteReg(()).payload(), "of 0 registers"),
        (lambda: WriteReg(((0, 0),) * 68).payload(), "of 68 registers"),
        (lambda: ReadMem(2, 4).payload(), "0x2 is no multiple"),
        (lambda: ReadMem(-4, 4).payload(), "0x-4 is no multiple"),
        (lambda: ReadMem(1 << 32, 4).payload(), "0x100000000 is no multiple"),
        (lambda: ReadMem(0, 0).payload(), "^0 bytes"),
        (lambda: ReadMem(0, 6).payload(), "^6 bytes"),
        (lambda: ReadMem(0, 540).payload(), "^540 bytes"),
        (lambda: WriteMem(0, b"abc").payload(), "^3 bytes"),
        (lambda: gvcp.encode_command(CommandCode.READREG, bytes(4), 0), "req_id 0 "),
        (lambda: gvcp.encode_command(CommandCode.READREG, bytes(4), 0x10000), "req_id 65536 "),
        (lambda: gvcp.encode_command(CommandCode.READREG, bytes(541), 1), "of 541 bytes"),
        (lambda: ForceIp("00:11", "10.0.0.1").encode(1), "'00:11' is no MAC"),
    ):
        with pytest.raises(LocalProtocolError, match=reason):
            build()


# Every number has its highest bit set, so that none is written or read as signed.
COMMANDS = [
    (ReadReg((0x80000004, 0x200)), "80000004 00000200"),
    (WriteReg(((0x80000004, 0x90000001), (8, 1))), "80000004 90000001 00000008 00000001"),
    (ReadMem(0x80000004, 536), "80000004 0000 0218"),
    (WriteMem(0x80000004, b"abcd"), "80000004 61626364"),
]
RESENDS = [
    (PacketResend(0x8001, 0x800002, 0x800003, 0x8004), "8004 8001 00800002 00800003"),
    (PacketResend(0x8001, 2, PacketResend.TO_THE_END), "0000 8001 00000002 00ffffff"),
    (
        PacketResend(1 << 63, 0x80000002, 0x80000003, 0x8004, extended=True),
        "8004 0000 80000002 80000003 8000000000000000",
    ),
]


@pytest.mark.parametrize(("message", "digits"), COMMANDS)
def test_the_bytes_of_a_command(message: gvcp.Request, digits: str) -> None:
    payload = bytes.fromhex(digits)
    assert message.payload() == payload
    assert type(message).decode(payload) == message
    for wrong in (b"", payload[:2], payload[:5]):
        with pytest.raises(RemoteProtocolError, match=f"{message.CODE.name} of {len(wrong)} bytes"):
            type(message).decode(wrong)


@pytest.mark.parametrize(("message", "digits"), RESENDS)
def test_the_bytes_of_a_request_to_send_again(message: PacketResend, digits: str) -> None:
    payload = bytes.fromhex(digits)
    flags = "10" if message.extended else "00"
    datagram = bytes.fromhex(f"42 {flags} 0040 {len(payload):04x} 8042") + payload
    assert message.encode(0x8042) == datagram
    assert PacketResend.decode(payload, message.flags) == message
    for wrong in (payload[:-1], payload + b"\0"):
        with pytest.raises(RemoteProtocolError, match=f"of {len(wrong)} bytes, need {len(payload)}"):
            PacketResend.decode(wrong, message.flags)


def test_the_bytes_of_acknowledges() -> None:
    ack = Ack(0x8006, 0x8001, 0x8042, b"ab")
    assert ack.encode() == bytes.fromhex("8006 8001 0002 8042 6162") and Ack.decode(ack.encode()) == ack
    assert ReadReg((0, 4)).decode_ack(bytes.fromhex("80000001 80000002")) == (0x80000001, 0x80000002)
    assert ReadMem.encode_ack(0x80000004, b"abcd") == bytes.fromhex("80000004 61626364")
    assert ReadMem(0x80000004, 4).decode_ack(bytes.fromhex("80000004 61626364")) == b"abcd"
    assert gvcp.encode_write_ack(0x8001) == bytes.fromhex("0000 8001")
    assert gvcp.encode_pending_ack(0x8000, 7) == bytes.fromhex("0000 0089 0004 0007 0000 8000")
    assert gvcp.decode_pending_ack(bytes.fromhex("0000 8000")) == 32.768


def test_the_bytes_of_another_address_are_not_taken_for_those_requested() -> None:
    with pytest.raises(RemoteProtocolError, match="4 bytes at 0x8, 4 at 0x4 were requested"):
        ReadMem(4, 4).decode_ack(bytes.fromhex("00000008 61626364"))
    for decode, digits, reason in (
        (ReadReg((0, 4)).decode_ack, "00000000", "1 registers, 2 were requested"),
        (ReadReg((0,)).decode_ack, "0000", "READREG_ACK of 2 bytes"),
        (ReadMem(4, 4).decode_ack, "000000", "of 3 bytes has no address"),
        (ReadMem(4, 4).decode_ack, "00000004", "of 0 bytes at 0x4"),
        (gvcp.decode_pending_ack, "000000", "of 3 bytes, need 4"),
        (Ack.decode, "0000 0081 0004", "of 6 bytes, need 8"),
        (Ack.decode, "0000 0081 0004 0001 00", "announces 4 bytes, 1 arrived"),
        (Ack.decode, "0001 0081 0004 0001 00", "announces 4 bytes, 1 arrived"),
    ):
        with pytest.raises(RemoteProtocolError, match=reason):
            decode(bytes.fromhex(digits))


def test_what_is_no_command_is_refused_with_its_reason() -> None:
    for datagram, reason in (
        ("42 01 0080 0000", "of 6 bytes, need 8"),
        ("43 01 0080 0000 0001", "begins with 0x43 instead of 0x42"),
        ("42 01 0080 0004 0001", "announces 4 bytes, 0 arrived"),
        ("42 01 0080 0000 0000", "^GVCP command with req_id 0$"),
    ):
        with pytest.raises(RemoteProtocolError, match=reason):
            gvcp.split_command(bytes.fromhex(datagram))
    with pytest.raises(RemoteProtocolError, match="WRITEREG of 12 bytes, need a multiple of 8"):
        WriteReg.decode(bytes(12))


def test_the_largest_commands_are_sent() -> None:
    assert (
        len(ReadReg((0,) * 135).payload()) == len(gvcp.encode_command(CommandCode.READREG, bytes(540), 1)) - 8
    )
    assert len(WriteReg(((0, 0),) * 67).payload()) == 536
    assert len(WriteMem(0xFFFFFFFC, bytes(536)).payload()) == 540
    assert ReadMem(0, 4).payload() == bytes.fromhex("00000000 0000 0004")
    for req_id in (1, 0xFFFF):
        assert gvcp.encode_command(CommandCode.READREG, b"", req_id)[6:] == req_id.to_bytes(2, "big")


def test_extended_resend_has_the_block_id_at_its_end() -> None:
    """The Aravis host's own bytes for packet 3 of block 0x100000002."""
    line, *_ = [line for line in lines("accept-extended-ids", "C") if line.data[2:4] == b"\0\x40"]
    header, payload = gvcp.split_command(line.data)
    assert PacketResend.decode(payload, header.flags) == PacketResend(0x100000002, 3, 3, extended=True)


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

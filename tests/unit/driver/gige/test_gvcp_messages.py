"""Events, actions, discovery and FORCEIP: messages and their bytes, both ways, cut at every length."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gige_transcripts import lines
from grabbergui.core.errors import LocalProtocolError, RemoteProtocolError
from grabbergui.driver.gige.gvcp import FLAG_EXTENDED_IDS, CommandCode, split_command
from grabbergui.driver.gige.gvcp_messages import NO_CHANNEL, Action, Event
from grabbergui.driver.gige.identity import ForceIp, Identity, encode_discovery, identity_texts, parse_mac

# Every number has its highest bit set, so that none is written or read as signed.
EVENTS = [
    (Event(0x9001, 0x8234, 1 << 63, channel=0x8005), "00c0", "0000 9001 8005 8234 8000000000000000"),
    (Event(3), "00c0", "0000 0003 ffff 0000 0000000000000000"),
    (Event(0x9001, 2, 3, data=b"abcd"), "00c2", "0000 9001 ffff 0002 0000000000000003 61626364"),
]
EXTENDED_EVENTS = [
    (
        Event(0x9001, 1 << 63 | 5, 1 << 63 | 6, 0x8005, extended=True),
        "00c0",
        "0018 9001 8005 0000 8000000000000005 8000000000000006",
    ),
    (
        Event(0x9001, 5, 6, data=b"abcd", extended=True),
        "00c2",
        "001c 9001 ffff 0000 0000000000000005 0000000000000006 61626364",
    ),
]
ACTIONS = [
    (Action(0x80000001, 0x80000002, 0x80000003), "01", "80000001 80000002 80000003"),
    (Action(1, 2, 3, 1 << 63 | 4), "81", "00000001 00000002 00000003 8000000000000004"),
    (Action(1, 2, 3, 0), "81", "00000001 00000002 00000003 0000000000000000"),
]
FORCED = ForceIp("00:11:22:aa:bb:cc", "192.168.7.8", "255.255.0.0", "192.168.7.1")
FORCED_PAYLOAD = f"0000 001122aabbcc {'00' * 12} c0a80708 {'00' * 12} ffff0000 {'00' * 12} c0a80701"


@pytest.mark.parametrize(("event", "code", "entry"), EVENTS + EXTENDED_EVENTS)
def test_the_bytes_of_an_event(event: Event, code: str, entry: str) -> None:
    body = bytes.fromhex(entry)
    assert event.entry() == body, "as GenApi's event ports address it"
    for required, flags in ((True, 0x01), (False, 0x00)):
        flags |= 0x10 if event.extended else 0
        datagram = event.encode(0x8042, ack_required=required)
        assert datagram == bytes.fromhex(f"42 {flags:02x} {code} {len(body):04x} 8042") + body
        header, payload = split_command(datagram)
        assert Event.decode_all(header.command, payload, header.flags) == (event,)
    assert event.encode(1)[1] & 0x01, "acknowledged by default"


@pytest.mark.parametrize(("event", "code", "entry"), EVENTS + EXTENDED_EVENTS)
def test_an_event_that_is_cut_off_is_refused(event: Event, code: str, entry: str) -> None:
    body = bytes.fromhex(entry)
    head, flags = (24, FLAG_EXTENDED_IDS) if event.extended else (16, 0)
    # A standard EVENTDATA does not say how long its data is.
    shortest = head if event.data and not event.extended else len(body)
    for length in range(1, shortest):
        with pytest.raises(
            RemoteProtocolError, match=rf"GVCP event of .* {length} arrived|of {length} bytes"
        ):
            Event.decode_all(int(code, 16), body[:length], flags)
    assert Event.decode_all(int(code, 16), b"", flags) == ()


def test_each_event_of_a_message_is_read() -> None:
    first, second = Event(3, 7, 8), Event(4, 9, 10)
    both = first.entry() + second.entry()
    assert Event.decode_all(CommandCode.EVENT, both, 0) == (first, second)
    with pytest.raises(RemoteProtocolError, match="of 9 bytes, need 16"):
        Event.decode_all(CommandCode.EVENT, both + bytes(9), 0)
    with pytest.raises(RemoteProtocolError, match="of 8 bytes, need 24"):
        Event.decode_all(CommandCode.EVENT, both, FLAG_EXTENDED_IDS)


def test_extended_events_with_data_say_where_the_next_begins() -> None:
    first, second = (Event(number, data=bytes([number]) * 4, extended=True) for number in (3, 4))
    both = first.entry() + second.entry()
    assert Event.decode_all(CommandCode.EVENTDATA, both, FLAG_EXTENDED_IDS) == (first, second)
    unsized = b"\0\0" + both[2:]  # GigE Vision 2.0 has no size there, and one event in a message
    (event,) = Event.decode_all(CommandCode.EVENTDATA, unsized, FLAG_EXTENDED_IDS)
    assert event.data == both[24:]
    for size, fits in ((23, False), (24, True), (28, True), (29, False)):
        entry = size.to_bytes(2, "big") + first.entry()[2:]
        if not fits:
            with pytest.raises(RemoteProtocolError, match=f"event of {size} bytes, 28 arrived"):
                Event.decode_all(CommandCode.EVENTDATA, entry, FLAG_EXTENDED_IDS)
        elif size == 28:
            assert Event.decode_all(CommandCode.EVENTDATA, entry, FLAG_EXTENDED_IDS) == (first,)
    later = first.entry() + b"\0\x1d" + second.entry()[2:]
    with pytest.raises(RemoteProtocolError, match="event of 29 bytes, 28 arrived"):
        Event.decode_all(CommandCode.EVENTDATA, later, FLAG_EXTENDED_IDS)


@pytest.mark.parametrize("name", ["viva-event", "viva-eventdata"])
def test_captured_events_are_read_and_written_byte_by_byte(name: str) -> None:
    for number, line in enumerate(lines(name, "E"), 1):
        header, payload = split_command(line.data)
        (event,) = Event.decode_all(header.command, payload, header.flags)
        assert event.encode(header.req_id, ack_required=False) == line.data
        assert event.block_id == number and event.channel in (0, NO_CHANNEL)


@pytest.mark.parametrize(("action", "flags", "keys"), ACTIONS)
def test_the_bytes_of_an_action(action: Action, flags: str, keys: str) -> None:
    payload = bytes.fromhex(keys)
    head = f"0100 {len(payload):04x} 8042"
    assert action.encode(0x8042) == bytes.fromhex(f"42 {flags} {head}") + payload
    silent = f"{int(flags, 16) & ~1:02x}"
    assert action.encode(0x8042, ack_required=False) == bytes.fromhex(f"42 {silent} {head}") + payload
    assert Action.decode(payload, int(flags, 16)) == action
    for length in (*range(len(payload)), len(payload) + 4):
        with pytest.raises(RemoteProtocolError, match=f"ACTION of {length} bytes, need {len(payload)}"):
            Action.decode(payload[:length].ljust(length, b"\0"), int(flags, 16))


def test_captured_actions_are_read_and_written_byte_by_byte() -> None:
    for line in lines("viva-action", "C"):
        header, payload = split_command(line.data)
        again = Action.decode(payload, header.flags).encode(header.req_id)
        assert again == line.data[:1] + bytes([header.flags & ~0x10]) + line.data[2:], "0x10: by broadcast"


def test_the_bytes_of_discovery() -> None:
    assert encode_discovery() == bytes.fromhex("42 01 0002 0000 ffff")
    assert encode_discovery(7, allow_broadcast_ack=True) == bytes.fromhex("42 11 0002 0000 0007")


def test_the_bytes_of_forceip() -> None:
    payload = bytes.fromhex(FORCED_PAYLOAD)
    assert FORCED.encode(7) == bytes.fromhex("42 11 0004 0038 0007") + payload
    alone = FORCED.encode(7, allow_broadcast_ack=False)
    assert alone == bytes.fromhex("42 01 0004 0038 0007") + payload
    assert ForceIp.decode(payload) == FORCED
    for length in (*range(56), 57):
        with pytest.raises(RemoteProtocolError, match=f"FORCEIP of {length} bytes, need 56"):
            ForceIp.decode(payload[:length].ljust(length, b"\0"))


@pytest.mark.parametrize("ip", ["10.0.0.256", "192.168.1", "10", "10.0.0.2 10.0.0.3", "0x7f.1", ""])
def test_forceip_sends_only_whole_addresses(ip: str) -> None:
    with pytest.raises(LocalProtocolError, match=rf"ip='{ip}'.*"):
        ForceIp("00:11:22:33:44:55", ip).encode(1)


IDENTITY = Identity(
    mac="80:11:22:aa:bb:cc",
    ip="192.168.0.2",
    subnet_mask="255.255.255.0",
    gateway="192.168.0.1",
    vendor="Vendor",
    model="Model",
    version="1.2.3",
    manufacturer_info="Info",
    serial="S-1",
    user_name="Käfer",
    spec_version=(0x8001, 0x8002),
    device_mode=0x80000001,
    supported_ip_configuration=0x80000007,
    current_ip_configuration=0x80000005,
)
IDENTITY_FIELDS = (
    ("8001 8002", 0),
    ("80000001", 4),
    ("80 11 22 aa bb cc", 10),
    ("80000007", 16),
    ("80000005", 20),
    ("c0a80002", 36),
    ("ffffff00", 52),
    ("c0a80001", 68),
    (b"Vendor".hex(), 72),
    (b"Model".hex(), 104),
    (b"1.2.3".hex(), 136),
    (b"Info".hex(), 168),
    (b"S-1".hex(), 216),
    ("Käfer".encode().hex(), 232),
)
"With its offset in DISCOVERY_ACK, which is the address of a register."


def identity_bytes() -> bytes:
    memory = bytearray(248)
    for digits, at in IDENTITY_FIELDS:
        field = bytes.fromhex(digits)
        memory[at : at + len(field)] = field
    return bytes(memory)


def test_the_bytes_of_an_identity() -> None:
    assert IDENTITY.encode() == identity_bytes()
    assert Identity.decode(identity_bytes()) == IDENTITY
    assert Identity.decode(identity_bytes() + b"more") == IDENTITY
    assert Identity.decode(Identity().encode()) == Identity()
    with pytest.raises(RemoteProtocolError, match="of 247 bytes, need 248"):
        Identity.decode(identity_bytes()[:247])


def test_an_open_camera_is_described_by_its_registers() -> None:
    memory = identity_bytes()
    texts = identity_texts(lambda address, length: memory[address : address + length])
    assert texts == {
        "vendor": "Vendor",
        "model": "Model",
        "version": "1.2.3",
        "serial": "S-1",
        "user_name": "Käfer",
        "hardware_id": "80:11:22:aa:bb:cc",
    }
    assert identity_texts(lambda address, length: Identity().encode())["hardware_id"] == "", (
        "none is reported"
    )


def test_mac_addresses_in_every_spelling() -> None:
    for text in ("00:30:53:0a:0b:0c", "00-30-53-0A-0B-0C", "0030530a0b0c"):
        assert parse_mac(text) == b"\x00\x30\x53\x0a\x0b\x0c"
    for text in ("00:30:53", "00:30:53:0a:0b:0g", "00:30:53:0a:0b:0c:0d", ""):
        with pytest.raises(ValueError, match=f"'{text}' is no MAC address"):
            parse_mac(text)


@given(st.binary(max_size=120), st.integers(0, 255), st.sampled_from(["EVENT", "EVENTDATA"]))
def test_no_message_crashes_a_parser(payload: bytes, flags: int, name: str) -> None:
    for parse in (
        lambda: Event.decode_all(CommandCode[name], payload, flags),
        lambda: Action.decode(payload, flags),
        lambda: ForceIp.decode(payload),
    ):
        try:
            parse()
        except RemoteProtocolError as error:
            assert str(error)

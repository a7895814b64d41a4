from contextlib import nullcontext

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from every_case import every_case
from grabbergui.core.errors import AccessDeniedError, LocalProtocolError, RemoteProtocolError
from grabbergui.net.yarp import image
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os.authentication import Handshake
from grabbergui.net.yarp.os.binary import (
    COMMAND_LIMIT,
    INDEX_MAGIC,
    MAGIC_BASE,
    decode_name,
    decode_name_size,
    encode_message,
    encode_number,
)
from grabbergui.net.yarp.os.carrier import encode_header, modifiers_of
from grabbergui.net.yarp.os.connection import YarpConnection
from grabbergui.net.yarp.os.datagrams import Reassembler, split_datagrams
from grabbergui.net.yarp.os.events import Header
from grabbergui.net.yarp.os.framing import Receiver
from grabbergui.net.yarp.os.stamp import Stamp
from yarp_transcripts import read, streams


def fresh(size):
    return memoryview(bytearray(size))


def feed(receiver, data, step=1 << 30):
    pieces = (data[start : start + step] for start in range(0, len(data), step))
    return [message for piece in pieces for message in receiver.feed(piece)]


def greeted(client):
    """The sender's name, and what it says once the greeting is answered."""
    end = 12 + decode_name_size(client[8:12])
    return decode_name(client[12:end]), client[end:]


@every_case(
    ("name", "carrier"),
    [
        ("stream_tcp_312", wire.TCP),
        ("stream_fast_tcp_312", wire.FAST_TCP),
        ("stream_fast_tcp_40", wire.FAST_TCP),
        ("stream_mono_padding_312", None),
    ],
)
@every_case("step", [1, 7, 1 << 30])
def test_image_streams_of_a_real_yarp_are_read_in_pieces_of_any_size(name, carrier, step):
    carriers = [carrier] if carrier else [wire.TCP, wire.FAST_TCP]
    seen = 0
    for kind in carriers:
        greeting = encode_number(MAGIC_BASE + kind.code)
        for conversation in streams(name, greeting):
            assert wire.identify(conversation.client) is kind
            receiver = Receiver()
            sender, data = greeted(conversation.client)
            messages = feed(receiver, data, step)
            assert sender.startswith("/") and receiver.idle
            for message in messages:
                if message.code == "D" and len(message.body):
                    seen += 1
                    header, pixels = image.decode(message.body)
                    assert pixels.shape[:2] == (header.height, header.width)
                    assert Stamp.decode(message.envelope).encode() == message.envelope
    assert seen >= 3


def test_our_message_is_byte_for_byte_that_of_yarp():
    greeting = encode_number(MAGIC_BASE + wire.TCP.code)
    conversation = next(c for c in streams("stream_tcp_312", greeting) if b"mat" in c.client)
    recorded = next(data for side, data in conversation.turns if side == "C" and b"mat" in data)
    start = recorded.find(encode_number(INDEX_MAGIC))
    (message,) = feed(Receiver(), recorded[start:])[:1]
    body = bytes(message.body)
    ours = b"".join(encode_message(message.command, [body[:60], body[60:]]))
    assert recorded[start:].startswith(ours)
    assert encode_header(wire.TCP, "/grabber") == conversation.client[: 8 + 4 + 9]


def test_real_datagrams_are_joined_and_ours_are_cut_alike():
    for name in ("stream_udp_312", "stream_udp_multidatagram_312", "stream_mcast_312"):
        count = 0
        for conversation in read(name):
            joiner = Reassembler(fresh, 1 << 24)
            recorded = []
            for side, data in conversation.turns:
                if side != "U" or data[4:8] == b"\xff\xff\xff\xff":
                    continue
                recorded.append(data)
                message = joiner.datagram(data)
                if message is None or message.code != "D":
                    continue
                count += 1
                body = bytes(message.body)
                ours = split_datagrams(encode_message(message.command, [body[:60], body[60:]]))
                assert [b"".join(parts) for parts in ours] == recorded[-(recorded[-1][4] + 1) :]
        assert count


def datagrams(command, body, limit=65499):
    return [b"".join(parts) for parts in split_datagrams(encode_message(command, [body]), limit)]


@given(st.binary(min_size=0, max_size=300), st.integers(20, 60), st.sets(st.integers(0, 40)))
def test_lost_datagrams_cost_their_message_only(body, limit, lost):
    joiner = Reassembler(fresh, 1 << 16)
    first = datagrams("D 1 2", body, limit)
    assert {len(datagram) for datagram in first[:-1]} <= {limit} and len(first[-1]) <= limit
    messages = [joiner.datagram(datagram) for number, datagram in enumerate(first) if number not in lost]
    arrived = [bytes(message.body) for message in messages if message is not None]
    assert arrived == ([] if lost & set(range(len(first))) else [body])
    assert joiner.datagram(*datagrams("D", b"next")).body == b"next"


def damaged(datagram):
    return datagram[:-1] + bytes((datagram[-1] ^ 1,))


BODY = bytes(range(100))
FIRST = datagrams("D", BODY, 40)
WAKE_UP = b"\0\0\0\0\xff\xff\xff\xff"


@pytest.mark.parametrize(
    ("sequence", "bodies"),
    [
        (FIRST, [BODY]),
        (FIRST * 2, [BODY, BODY]),
        ([*FIRST[:2], damaged(FIRST[2]), *FIRST[3:], *FIRST], [BODY]),
        ([damaged(FIRST[0]), *FIRST[1:], *FIRST], [BODY]),
        ([FIRST[0], FIRST[2], FIRST[1], *FIRST[3:], *FIRST], [BODY]),
        ([*FIRST[:2], *FIRST], [BODY]),
        ([*FIRST[:2], WAKE_UP, *FIRST[2:], *FIRST], [BODY, BODY]),
        ([*FIRST[:2], b"short", *FIRST[2:]], [BODY]),
        ([*datagrams("D", bytes(101), 40), *FIRST], [BODY]),
    ],
    ids=[
        "whole", "twice", "damaged", "damaged first", "out of order", "broken off", "wake-up", "foreign",
        "too long",
    ],
)  # fmt: skip
def test_messages_are_joined_from_datagrams_that_are_whole_and_in_order(sequence, bodies):
    made = []
    joiner = Reassembler(lambda size: made.append(fresh(size)) or made[-1], len(BODY) + 8)
    arrived = [message for datagram in sequence if (message := joiner.datagram(datagram)) is not None]
    assert [bytes(message.body) for message in arrived] == bodies
    assert all(any(message.body.obj is memory.obj for memory in made) for message in arrived)


@given(st.binary(max_size=400))
def test_random_bytes_never_break_the_receivers(data):
    try:
        feed(Receiver(limit=1 << 16), data)
    except RemoteProtocolError as error:
        assert str(error)
    Reassembler(fresh, 1 << 16).datagram(data)
    try:
        wire.identify(data)
    except RemoteProtocolError as error:
        assert str(error)


@given(
    st.text(st.characters(blacklist_characters="\0", codec="utf-8"), min_size=2),
    st.lists(st.binary(), max_size=300),
)
@example("D 1", [b"xy"] * 255)
def test_a_message_is_read_as_it_was_written(command, parts):
    data = b"".join(encode_message(command, parts))
    (message,) = feed(Receiver(), data)
    assert message.command == command and message.body == b"".join(parts)


def head(*lengths, blocks=None, number=INDEX_MAGIC):
    """The start of a message whose blocks have these lengths."""
    sizes = b"".join(length.to_bytes(4, "little", signed=True) for length in lengths)
    return encode_number(number) + bytes((blocks or len(lengths), 1)) + b"\xff" * 8 + sizes + bytes(4)


@every_case(
    ("data", "reason"),
    [
        (head(2**31 - 1), "message of 2147483647 bytes, allowed: 8 to 1000"),
        (head(8, 993), "message of 1001 bytes"),
        (head(1000, -1), "message of 999 bytes"),
        (head(7), "message of 7 bytes"),
        (head()[:-4] + bytes(8), "message of no blocks"),
        (head(8, number=11), "must begin with number 10"),
        (b"GET / HTTP/1.1\r\n\r\n", "where YA....RP was expected"),
        (head(8) + b"\0\0\0\0-d\0\1", "port command .*-d"),
        (head(8) + b"\0\0\0\0~d\1\1", "port command .*~d"),
        (head(8) + b"\0\0\0\0~d\0\0", "port command .*~d"),
        (head(8, 4) + b"\5\0\0\0~\0\0\1", "port command of 5 bytes, in a message of 4"),
        (head(8, 4) + b"\0\0\0\0~\0\0\1", "port command of 0 bytes"),
        (head(8, 4) + b"\xff\xff\xff\xff~\0\0\1", "port command of -1 bytes"),
    ],
)
def test_impossible_messages_are_refused_by_their_index(data, reason):
    for step in (1, len(data)):
        with pytest.raises(RemoteProtocolError, match=reason):
            feed(Receiver(limit=1000), data, step)


def test_port_commands_have_a_limit():
    for size, allowed in ((COMMAND_LIMIT, True), (COMMAND_LIMIT + 1, False)):
        data = b"".join(encode_message("/" + "n" * (size - 2)))
        with nullcontext() if allowed else pytest.raises(RemoteProtocolError, match="port command of 4001"):
            assert len(feed(Receiver(), data)) == 1


@every_case(
    ("envelope", "stamp"),
    [
        ("3 4.5", Stamp(3, 4.5)),
        ("2147483647 0", Stamp(2**31 - 1, 0.0)),
        ("2147483648 0", None),
        ("-1 0", None),
        ("3 inf", None),
        ("3 nan", None),
        ("3 1e300", None),
        ("3 9.3e9", None),  # more nanoseconds than 64 bits hold
        ("3 -1e10", None),
        ("3", None),
        ("three 4.5", None),
        ("", None),
    ],
)
def test_an_envelope_that_is_no_stamp_is_none(envelope, stamp):
    assert Stamp.decode(envelope) == stamp


@pytest.mark.parametrize(
    ("header", "name"),
    [
        (encode_number(MAGIC_BASE + 14), "shmem"),
        (encode_number(MAGIC_BASE + 77), "with code 77"),
    ],
)
def test_unknown_carriers_are_named(header, name):
    with pytest.raises(RemoteProtocolError, match=f"carrier {name} is not supported, use one of tcp, fast_"):
        wire.identify(header)


def test_unknown_carriers_are_named_to_who_wants_them():
    with pytest.raises(LocalProtocolError, match="carrier bluetooth is not supported, use one of tcp"):
        wire.by_name("bluetooth+recv.x")


def test_a_real_multicast_header_names_the_group():
    """And ours is the same byte for byte."""
    (conversation,) = streams("stream_mcast_312", encode_number(MAGIC_BASE + wire.MCAST.code))
    receiver = YarpConnection(opener=False)
    receiver.receive_data(conversation.client)
    header = receiver.next_event()
    assert header == Header(wire.MCAST, "/grabber", group=("224.1.1.3", 10007))
    assert b"".join(YarpConnection(opener=True).send(header)) == conversation.client
    assert not conversation.server, "the reader does not reply"


@pytest.mark.parametrize("group", [("10.0.0.1", 5000), ("224.1.1.1", 0), ("ff02::1", 5000), ("", 5000)])
def test_what_is_no_multicast_group_is_refused(group):
    with pytest.raises(LocalProtocolError, match="no multicast group"):
        encode_header(wire.MCAST, "/a", group)


@pytest.mark.parametrize("group", [b"\x0a\0\0\1\x13\x88", b"\xe0\1\1\1\0\0"])
def test_a_header_with_an_address_of_one_machine_is_refused(group):
    receiver = YarpConnection(opener=False)
    receiver.receive_data(encode_header(wire.MCAST, "/a") + group)
    with pytest.raises(RemoteProtocolError, match="no multicast group"):
        receiver.next_event()


def test_authentication_succeeds_only_with_the_same_key():
    def talk(first, second):
        accepting, dialling = Handshake(first, accepting=True), Handshake(second, accepting=False)
        message = accepting.begin()
        while message:
            message = dialling.received(message)
            message = accepting.received(message) if message else b""
        return accepting.done and dialling.done

    assert talk(b"secret", b"secret")
    with pytest.raises(AccessDeniedError):
        talk(b"secret", b"guess")


def test_messages_that_come_together_are_taken_one_by_one():
    """And a head of any length allowed, wherever in the receiver's memory it begins."""
    receiver = Receiver()
    long = "/" + "n" * (COMMAND_LIMIT - 2)
    data = b"".join(
        b"".join(encode_message(command, parts))
        for command in ("d", long, "D 1 2")
        for parts in ([b"x"] * 254, [b"y" * 5000], [])
    )
    for step in (1, 3000, len(data)):
        taken = [(m.command, bytes(m.body)) for m in feed(receiver, data, step)]
        assert [command for command, _ in taken] == ["d"] * 3 + [long] * 3 + ["D 1 2"] * 3
        assert [body for _, body in taken] == [b"x" * 254, b"y" * 5000, b""] * 3
        assert receiver.idle


def test_an_image_is_read_into_allocated_memory_except_its_beginning():
    """Two reads a message: what came with the head is copied, the rest is read in its place."""
    made = []
    receiver = Receiver(allocate=lambda size: made.append(fresh(size)) or made[-1])
    data = b"".join(encode_message("D 1 2", [bytes(range(256)) * 400]))
    count = len(receiver.wanted)
    receiver.wanted[:] = data[:count]
    receiver.received(count)
    assert receiver.take() is None and receiver.in_body and not receiver.idle
    assert len(receiver.wanted) == len(data) - count
    receiver.wanted[:] = data[count:]
    receiver.received(len(data) - count)
    message = receiver.take()
    assert message.body.obj is made[0].obj and message.body == data[-102400:]


def test_a_carrier_has_modifiers_behind_plus_signs():
    assert modifiers_of("tcp+recv.portmonitor+file.depth.image") == {
        "recv": "portmonitor",
        "file": "depth.image",
    }
    assert modifiers_of("fast_tcp") == {} and modifiers_of("udp+log") == {"log": ""}

import pytest
from hypothesis import given
from hypothesis import strategies as st
from yarp_transcripts import read, streams

from grabbergui.core.errors import AccessDeniedError, LocalProtocolError, RemoteProtocolError
from grabbergui.net.yarp import image
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os.framing import Reassembler, Receiver, split_datagrams
from grabbergui.net.yarp.os.sockets import Handshake
from grabbergui.net.yarp.os.values import Stamp


def fresh(size):
    return memoryview(bytearray(size))


def feed(receiver, data, step=1 << 30):
    pieces = (data[start : start + step] for start in range(0, len(data), step))
    return [message for piece in pieces for message in receiver.feed(piece)]


def greeted(client):
    """The sender's name, and what it says once the greeting is answered."""
    end = 12 + wire.decode_name_size(client[8:12])
    return wire.decode_name(client[12:end]), client[end:]


@pytest.mark.parametrize(
    ("name", "carrier"),
    [
        ("stream_tcp_312", wire.TCP),
        ("stream_fast_tcp_312", wire.FAST_TCP),
        ("stream_fast_tcp_40", wire.FAST_TCP),
        ("stream_mono_padding_312", None),
    ],
)
@pytest.mark.parametrize("step", [1, 7, 1 << 30])
def test_real_image_streams(name, carrier, step):
    carriers = [carrier] if carrier else [wire.TCP, wire.FAST_TCP]
    seen = 0
    for kind in carriers:
        greeting = wire.encode_number(wire.MAGIC_BASE + kind.code)
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
    greeting = wire.encode_number(wire.MAGIC_BASE + wire.TCP.code)
    conversation = next(c for c in streams("stream_tcp_312", greeting) if b"mat" in c.client)
    recorded = next(data for side, data in conversation.turns if side == "C" and b"mat" in data)
    start = recorded.find(wire.encode_number(wire.INDEX_MAGIC))
    (message,) = feed(Receiver(), recorded[start:])[:1]
    body = bytes(message.body)
    ours = b"".join(wire.encode_message(message.command, [body[:60], body[60:]]))
    assert recorded[start:].startswith(ours)
    assert wire.encode_header(wire.TCP, "/grabber") == conversation.client[: 8 + 4 + 9]


def test_real_datagrams_are_joined_and_ours_are_cut_alike():
    for name in ("stream_udp_312", "stream_udp_multidatagram_312"):
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
                ours = split_datagrams(wire.encode_message(message.command, [body[:60], body[60:]]))
                assert [b"".join(parts) for parts in ours] == recorded[-(recorded[-1][4] + 1) :]
            assert not joiner.damaged
        assert count


@given(st.binary(min_size=0, max_size=300), st.integers(20, 60), st.sets(st.integers(0, 40)))
def test_lost_datagrams_cost_their_message_only(body, limit, lost):
    joiner = Reassembler(fresh, 1 << 16)
    first = [b"".join(parts) for parts in split_datagrams(wire.encode_message("D 1 2", [body]), limit)]
    for number, datagram in enumerate(first):
        if number not in lost:
            message = joiner.datagram(datagram)
            assert message is None or (message.body == body and not lost & set(range(len(first))))
    second = [
        joiner.datagram(b"".join(parts)) for parts in split_datagrams(wire.encode_message("D", [b"next"]))
    ]
    assert second[-1].body == b"next"


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
def test_messages_round_trip(command, parts):
    data = b"".join(wire.encode_message(command, parts))
    (message,) = feed(Receiver(), data)
    assert message.command == command and message.body == b"".join(parts)


def test_enormous_messages_are_refused_before_they_come():
    head = wire.encode_number(wire.INDEX_MAGIC) + b"\x01\x01" + b"\xff" * 8
    for lengths in (b"\xff\xff\xff\x7f", b"\xff\xff\xff\xff", b"\0\0\0\0"):
        with pytest.raises(RemoteProtocolError, match="bytes"):
            feed(Receiver(), head + lengths + b"\0\0\0\0")
    with pytest.raises(RemoteProtocolError, match="name"):
        wire.decode_name_size(b"\xff\xff\xff\x7f")


def test_unknown_carriers_are_named():
    with pytest.raises(RemoteProtocolError, match="shmem is not supported"):
        wire.identify(wire.encode_number(wire.MAGIC_BASE + 14))
    with pytest.raises(LocalProtocolError, match="carrier bluetooth is not supported, use one of tcp"):
        wire.by_name("bluetooth+recv.x")


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
    long = "/" + "n" * (wire.COMMAND_LIMIT - 2)
    data = b"".join(
        b"".join(wire.encode_message(command, parts))
        for command in ("d", long, "D 1 2")
        for parts in ([b"x"] * 254, [b"y" * 5000], [])
    )
    for step in (1, 3000, len(data)):
        taken = [(m.command, bytes(m.body)) for m in feed(receiver, data, step)]
        assert [command for command, _ in taken] == ["d"] * 3 + [long] * 3 + ["D 1 2"] * 3
        assert [body for _, body in taken] == [b"x" * 254, b"y" * 5000, b""] * 3
        assert receiver.idle


def test_an_image_goes_into_the_memory_made_for_it_but_for_its_beginning():
    """Two reads a message: what came with the head is copied, the rest is read in its place."""
    made = []
    receiver = Receiver(allocate=lambda size: made.append(fresh(size)) or made[-1])
    data = b"".join(wire.encode_message("D 1 2", [bytes(range(256)) * 400]))
    count = len(receiver.wanted)
    receiver.wanted[:] = data[:count]
    receiver.received(count)
    assert receiver.take() is None and receiver.in_body and not receiver.idle
    assert len(receiver.wanted) == len(data) - count
    receiver.wanted[:] = data[count:]
    receiver.received(len(data) - count)
    message = receiver.take()
    assert message.body.obj is made[0].obj and message.body == data[-102400:]

"""Messages and replies of an open connection, without sockets: answered once, within limits, not copied."""

from __future__ import annotations

from contextlib import nullcontext

import pytest

from grabbergui.core.errors import LocalProtocolError, RemoteProtocolError, TransportError
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os import codecs
from grabbergui.net.yarp.os.binary import ACK
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.codecs import NAMES_LIMIT, TextCodec
from grabbergui.net.yarp.os.connection import (
    NEED_DATA,
    PAUSED,
    Phase,
    YarpConnection,
)
from grabbergui.net.yarp.os.events import Acknowledgement, Closed, Header, Message, Reply
from grabbergui.net.yarp.os.values import Dialect, Float32, Vocab
from yarp_messages import BINARY, D, arriving, message, ready


def test_a_message_is_replied_to_once():
    opener, acceptor = ready()
    assert opener.next_event() is PAUSED
    arriving(acceptor, b"".join(opener.send(Message("d", BINARY))))
    acceptor.send(Reply(BINARY))
    with pytest.raises(LocalProtocolError):
        acceptor.send(Reply(BINARY))
    _, acceptor = ready()
    with pytest.raises(LocalProtocolError, match="without a message"):
        acceptor.send(Reply(BINARY))


def test_a_second_reply_is_the_peers_fault():
    opener, _ = ready()
    opener.send(Message("d", BINARY))
    with pytest.raises(RemoteProtocolError, match="acknowledgement"):
        arriving(opener, bytes(BINARY) * 2)
    assert opener.phase is Phase.ERROR
    with pytest.raises(TransportError, match="broken"):
        opener.next_event()


@pytest.mark.parametrize(
    "piece", [b"\r\n", b"a\r\n", b"four\r\n"], ids=["empty lines", "short lines", "lines"]
)
def test_a_reply_of_many_lines_has_a_limit(piece, monkeypatch):
    monkeypatch.setattr(TextCodec, "_limit", 12)
    for count, allowed in ((12 // len(piece), True), (12 // len(piece) + 1, False)):
        opener, _ = ready(wire.TEXT_ACK)
        for _ in range(2):  # each reply has the whole limit
            opener.send(Message("d", text=""))
            with nullcontext() if allowed else pytest.raises(RemoteProtocolError, match="more than 12 bytes"):
                (reply, ack) = arriving(opener, piece * count + b"<ACK>\r\n")
                assert reply.text + "\r\n" == (piece * count).decode() and ack == Acknowledgement()
            if not allowed:
                break


def test_a_name_servers_answer_has_a_limit():
    client = YarpConnection(opener=True)
    client.send(Header(wire.NAME_SER, ""))
    client.send(Message("d", text="NAME_SERVER list"))
    line = b"registration name /a" + b"a" * 50_000 + b"\r\n"
    for _ in range(NAMES_LIMIT // len(line)):
        assert arriving(client, line) == []
    with pytest.raises(RemoteProtocolError, match=f"more than {NAMES_LIMIT} bytes"):
        arriving(client, line)


def test_a_binary_reply_has_a_limit(monkeypatch):
    allowed, too_long = (Bottle([bytes(size)]).encode() for size in (84, 85))
    monkeypatch.setattr(codecs, "REPLY_LIMIT", len(allowed))
    for reply in (allowed, too_long):
        opener, _ = ready()
        opener.send(Message("d", BINARY))
        with nullcontext() if reply is allowed else pytest.raises(RemoteProtocolError, match="bytes"):
            assert arriving(opener, reply + ACK, 1)[-1] == Acknowledgement()


@pytest.mark.parametrize("dialect", Dialect)
def test_a_short_reply_is_decoded_once(dialect):
    opener, _ = ready()
    opener.expect_replies(dialect)
    opener.send(Message("d", BINARY))
    data = Bottle([1, Float32(2.5), "a"]).encode(dialect)
    reply, ack = arriving(opener, data + ACK)
    assert reply.bottle == [1, 2.5, "a"] and reply.body == data and ack == Acknowledgement()
    assert opener.missing == 1


def test_an_acknowledgement_within_a_reply_does_not_end_it():
    opener, _ = ready()
    opener.send(Message("d", BINARY))
    data = Bottle(["a", ACK, 5]).encode()
    reply, ack = arriving(opener, data + ACK, 1)
    assert reply.body == data and ack == Acknowledgement()


@pytest.mark.parametrize("carrier", [wire.TCP, wire.FAST_TCP])
def test_a_message_longer_than_the_acceptor_allows_is_refused(carrier):
    for size, allowed in ((92, True), (93, False)):
        opener, acceptor = ready(carrier, limit=100)
        data = b"".join(opener.send(Message("D", parts=[bytes(size)])))
        with nullcontext() if allowed else pytest.raises(RemoteProtocolError, match="allowed: 8 to 100"):
            assert len(arriving(acceptor, data)) == 1


def test_the_end_of_the_stream_may_be_read_where_a_message_is_wanted():
    _, acceptor = ready()
    acceptor.received(0)
    assert acceptor.next_event() == Closed()
    _, acceptor = ready()
    data = message(D, BINARY)[:-1]
    acceptor.wanted[: len(data)] = data
    acceptor.received(len(data))
    assert acceptor.next_event() is NEED_DATA and acceptor.in_body
    acceptor.received(0)
    with pytest.raises(TransportError, match="within a message"):
        acceptor.next_event()


def test_bodies_are_read_into_their_memory_and_written_from_theirs():
    made = []

    def allocate(size):
        made.append(bytearray(size))
        return memoryview(made[-1])

    opener, acceptor = ready(allocate=allocate)
    image = memoryview(bytearray(range(256)) * 1000)
    start, sent = opener.send(Message("D", parts=[image]))
    assert sent is image
    data = bytes(start) + bytes(image)
    while (event := acceptor.next_event()) is NEED_DATA:
        wanted = acceptor.wanted
        piece, data = data[: len(wanted)], data[len(wanted) :]
        wanted[: len(piece)] = piece
        acceptor.received(len(piece))
    assert event.body.obj is made[0] and event.body == image


def test_a_long_reply_is_not_copied_when_it_is_complete():
    opener, _ = ready()
    opener.send(Message("d", BINARY))
    reply = Bottle([Vocab("ok"), bytes(3_000_000)]).encode()
    opener.receive_data(reply[:100_000])
    assert opener.next_event() is NEED_DATA and opener.missing == len(reply) - 100_000
    opener.receive_data(reply[100_000:] + ACK)
    held = opener._data.data
    assert opener.next_event().body.obj is held
    assert opener.missing == 1 and opener.next_event() == Acknowledgement()

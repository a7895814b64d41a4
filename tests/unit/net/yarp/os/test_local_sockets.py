"""Messages over unix_stream: no index before them, so the Bottle or the image shows where it ends."""

from __future__ import annotations

import socket
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from grabbergui.core.errors import RemoteProtocolError, TransportError
from grabbergui.net.yarp.os import local_sockets
from grabbergui.net.yarp.os.binary import encode_command
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.carrier import UNIX_STREAM, encode_header, identify
from grabbergui.net.yarp.os.framing import new_memory
from grabbergui.net.yarp.os.local_sockets import LocalReceiver

GREETING = bytes.fromhex("00000000 7e440001 04010000 01000000 03000000 686921")
"""`D` and the Bottle `hi!`, as YARP 3.12 writes them."""


@pytest.fixture
def ends() -> Iterator[tuple[socket.socket, socket.socket]]:
    ours, theirs = socket.socketpair()
    ours.settimeout(5.0)
    with ours, theirs:
        yield ours, theirs


def receiver(limit: int = 1 << 20) -> LocalReceiver:
    return LocalReceiver(new_memory, limit)


def test_the_header_has_the_carriers_name_and_the_senders() -> None:
    header = encode_header(UNIX_STREAM, "/out")
    assert header == b"UNIX_STR\x05\0\0\0/out\0"
    assert identify(header) is UNIX_STREAM


def test_a_message_is_read_whole_byte_by_byte_and_with_another_behind_it(
    ends: tuple[socket.socket, socket.socket],
) -> None:
    ours, theirs = ends
    messages = receiver()
    theirs.sendall(GREETING + GREETING)
    for _ in range(2):
        message = messages.next_message(ours)
        assert message is not None and message.command == "D"
        assert Bottle.decode(message.body).to_text() == '"hi!"'

    def drop() -> None:
        for byte in GREETING:
            theirs.send(bytes([byte]))

    thread = threading.Thread(target=drop)
    thread.start()
    message = messages.next_message(ours)
    thread.join()
    assert message is not None and Bottle.decode(message.body).to_text() == '"hi!"'
    theirs.close()
    assert messages.next_message(ours) is None


def test_a_long_message_and_its_envelope_arrive(ends: tuple[socket.socket, socket.socket]) -> None:
    ours, theirs = ends
    body = Bottle([b"\7" * 300_000, 5]).encode()
    thread = threading.Thread(target=theirs.sendall, args=(encode_command("D 3 1.5") + body,))
    thread.start()
    message = receiver().next_message(ours)
    thread.join()
    assert message is not None and message.envelope == "3 1.5" and message.body == body


@pytest.mark.parametrize("size", range(1, len(GREETING)))
def test_a_message_that_is_cut_off_is_none(size: int, ends: tuple[socket.socket, socket.socket]) -> None:
    ours, theirs = ends
    theirs.sendall(GREETING[:size])
    theirs.close()
    if size < 8:
        assert receiver().next_message(ours) is None
    else:
        with pytest.raises(TransportError, match="within a message"):
            receiver().next_message(ours)


@pytest.mark.parametrize(
    "sent", [b"garbage!" * 4, GREETING[:8] + b"\xff" * 20, GREETING[:12] + b"\xff\xff\xff\x7f" + bytes(20)]
)
def test_what_is_no_message_is_refused(sent: bytes, ends: tuple[socket.socket, socket.socket]) -> None:
    ours, theirs = ends
    theirs.sendall(sent)
    with pytest.raises(RemoteProtocolError):
        receiver().next_message(ours)


def test_a_message_beyond_the_limit_is_refused(ends: tuple[socket.socket, socket.socket]) -> None:
    ours, theirs = ends
    theirs.sendall(encode_command("D") + Bottle([b"\7" * 5000]).encode())
    with pytest.raises(RemoteProtocolError, match="at most 1000"):
        receiver(1000).next_message(ours)


def test_the_folder_of_the_sockets_is_yarps(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for name in ("YARP_RUNTIME_DIR", "XDG_RUNTIME_DIR", "USER"):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(TransportError, match="YARP_RUNTIME_DIR"):
        local_sockets.runtime_folder()
    monkeypatch.setenv("USER", "ada")
    assert local_sockets.runtime_folder().parts[-2:] == ("runtime-ada", "yarp")
    monkeypatch.setenv("XDG_RUNTIME_DIR", "/run/user/1000")
    assert local_sockets.runtime_folder() == Path("/run/user/1000/yarp")
    monkeypatch.setenv("YARP_RUNTIME_DIR", str(tmp_path))
    assert local_sockets.runtime_folder() == tmp_path

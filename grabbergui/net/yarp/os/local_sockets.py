"""Sockets of the carrier unix_stream: one in the file system, named after the ports of the TCP connection.

The opener sends its header over TCP, and both ends leave that connection: the acceptor listens at
`ACCEPTOR_OPENER.sock` in YARP's runtime folder, and the opener connects there. Messages follow without an
index: a command, then a Bottle or an image, which show where they end.
"""

from __future__ import annotations

import os
import socket
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Final

from grabbergui.core.errors import TransportError
from grabbergui.core.shared_folder import opened, temporary
from grabbergui.net.yarp.os.binary import COMMAND_LIMIT, decode_command
from grabbergui.net.yarp.os.events import Message
from grabbergui.net.yarp.os.framing import BottleScanner
from grabbergui.net.yarp.os.sockets import reason

_READY_S: Final = 5.0
"Seconds within which the acceptor listens and the opener connects."
_RETRY_S: Final = 0.01
_READ_BYTES: Final = 65536
"Least to ask for at a time."


def runtime_folder() -> Path:
    """Return the folder of the sockets, as YARP finds it. Raises TransportError if there is none."""
    environment = os.environ
    if folder := environment.get("YARP_RUNTIME_DIR"):
        return Path(folder)
    if folder := environment.get("XDG_RUNTIME_DIR"):
        return Path(folder) / "yarp"
    if user := environment.get("USER"):
        return temporary() / f"runtime-{user}" / "yarp"
    raise TransportError("unix_stream needs a folder for its sockets: set YARP_RUNTIME_DIR")


def _require_same_computer(sock: socket.socket) -> None:
    if sock.getsockname()[0] != sock.getpeername()[0]:
        raise TransportError("unix_stream connects ports of one computer: choose another carrier")


def _local_socket() -> socket.socket:
    if sys.platform == "win32":
        raise TransportError("unix_stream is not possible on Windows: choose another carrier")
    return socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)


def local_sender(sock: socket.socket) -> socket.socket:
    """Leave a TCP connection that we opened for the acceptor's local socket. Raises TransportError."""
    _require_same_computer(sock)
    path = runtime_folder() / f"{sock.getpeername()[1]}_{sock.getsockname()[1]}.sock"
    sock.close()
    local = _local_socket()
    deadline = time.monotonic() + _READY_S
    while True:
        try:
            local.connect(str(path))
        except OSError as error:
            if time.monotonic() > deadline:
                local.close()
                raise TransportError(f"nobody listens at {path}: {reason(error)}") from error
            time.sleep(_RETRY_S)
        else:
            return local


def local_receiver(sock: socket.socket) -> socket.socket:
    """Leave a TCP connection that we accepted for a local socket, and return it. Raises TransportError."""
    _require_same_computer(sock)
    path = runtime_folder() / f"{sock.getsockname()[1]}_{sock.getpeername()[1]}.sock"
    sock.close()
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        with opened(path.parent, folder=True):  # not another user's
            path.unlink(missing_ok=True)
        with _local_socket() as listener:
            listener.bind(str(path))
            listener.listen(1)
            listener.settimeout(_READY_S)
            local, _ = listener.accept()
    except OSError as error:
        raise TransportError(f"unix_stream at {path}: {reason(error)}") from error
    finally:
        with suppress(OSError):
            path.unlink(missing_ok=True)
    return local


class LocalReceiver:
    """Takes the messages from the bytes of a local socket."""

    def __init__(self, allocate: Callable[[int], memoryview], limit: int) -> None:
        """`allocate` returns memory for a body; no message longer than `limit` bytes is accepted."""
        self._allocate, self._limit = allocate, limit
        self._data = bytearray()

    def next_message(self, sock: socket.socket) -> Message | None:
        """Return the next message; None at the end. Raises RemoteProtocolError, TransportError."""
        data = self._data
        while (index := decode_command(memoryview(bytes(data[:COMMAND_LIMIT])))) is None:
            if not self._fill(sock, 1):
                return None
        del data[: index.size]
        if index.command[:1] not in "adD":
            return Message(index.command)
        scanner = BottleScanner(limit=self._limit)
        while (size := scanner.scan(data)) > len(data):
            if not self._fill(sock, size - len(data)):
                raise TransportError("the sender closed the connection within a message")
        body = self._allocate(size)
        body[:] = memoryview(data)[:size]
        del data[:size]
        return Message(index.command, body)

    def _fill(self, sock: socket.socket, missing: int) -> bool:
        """Read at least so many bytes; return False at the end."""
        piece, count = memoryview(bytearray(max(missing, _READ_BYTES))), 0
        while count < missing:
            try:
                received = sock.recv_into(piece[count:])
            except ConnectionResetError:
                received = 0
            except OSError as error:
                raise TransportError(reason(error)) from error
            if not received:
                return False
            count += received
        self._data += piece[:count]
        return True

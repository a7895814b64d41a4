"""The guardian's stop channels on YARP: a message on a stream, or a request with a reply.

The robot defines the messages; this module keeps the connections, which are open before they are needed.
"""

from __future__ import annotations

import socket

from typing_extensions import override

from grabbergui.core.errors import TransportError
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os import sockets
from grabbergui.net.yarp.os.binary import encode_message
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.events import Header
from grabbergui.net.yarp.os.link import greet
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.rpc_client import RpcClient
from grabbergui.net.yarp.os.values import Dialect, Vocab
from grabbergui.servo.stop_channel import Channel

SENDER = "grabbergui/guardian"
TIMEOUT = 1.0
"Seconds for a connection, and for an answer."


class FastTcpChannel(Channel):
    """Sends a Bottle to a port over fast_tcp, without an answer: the fastest stop."""

    def __init__(self, port: str, nameserver: str, stop: str, dialect: str = "3.x") -> None:
        """`stop` is the Bottle as text, `dialect` a `Dialect`'s value."""
        self.name = port
        self._names = NameClient.find(nameserver)
        self._stop = encode_message("D", [_encoded(stop, Dialect(dialect))])
        self._sock: socket.socket | None = None

    @override
    def prepare(self) -> None:
        self._connected()

    @override
    def stop(self) -> None:
        sockets.send(self._connected(), self._stop)

    @override
    def close(self) -> None:
        if self._sock is not None:
            sockets.shut_down(self._sock)
            self._sock = None

    def _connected(self) -> socket.socket:
        if self._sock is None or sockets.closed_by_peer(self._sock):
            self.close()
            address = self._names.query(self.name).address
            sock = sockets.connect(address, TIMEOUT, self._names.key)
            self._sock = greet(sock, Header(wire.FAST_TCP, SENDER))[0].sock
        return self._sock


class RequestChannel(Channel):
    """Asks a port, and expects `ok` somewhere in its answer."""

    def __init__(self, port: str, nameserver: str, stop: str, check: str, dialect: str = "3.x") -> None:
        """`stop` and `check` are Bottles as text; the second moves nothing, and is asked now and then."""
        self.name = port
        self._client = RpcClient(port, NameClient.find(nameserver), sender=SENDER)
        self._client.dialect = Dialect(dialect)
        self._stop, self._check = (_encoded(text, self._client.dialect) for text in (stop, check))
        self._stop_text = stop

    @override
    def prepare(self) -> None:
        self._client.call(self._check, TIMEOUT)

    @override
    def stop(self) -> None:
        reply = self._client.call(self._stop, TIMEOUT)
        if Vocab("ok") not in (reply or []):
            raise TransportError(f"it refused {self._stop_text}: {reply}")

    @override
    def close(self) -> None:
        self._client.close()


def _encoded(text: str, dialect: Dialect) -> bytes:
    return Bottle.from_text(text, dialect).encode(dialect)

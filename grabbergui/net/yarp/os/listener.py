"""Accepts connections and hands each to a thread of its own."""

from __future__ import annotations

import selectors
import socket
import threading
from collections.abc import Callable
from typing import Final

from grabbergui.core.errors import (
    ResourceExhaustedError,
    TransportError,
)
from grabbergui.net.yarp.os import sockets

_PAUSE_SECONDS: Final = 0.2
"""Pause before the next connection is accepted after descriptors or threads ran out."""

# Neither needs a descriptor of its own, and poll has no highest one.
_Selector = getattr(selectors, "PollSelector", selectors.SelectSelector)


class Listener:
    """Accepts connections until closed.

    `on_connection` is called with a socket and the peer's IP address, on the listener's thread. If it raises
    ResourceExhaustedError, or there is no descriptor for a connection, `on_shortage` is called with the
    reason, and the listener pauses.
    """

    def __init__(
        self,
        name: str,
        on_connection: Callable[[socket.socket, str], None],
        on_shortage: Callable[[str], None],
    ) -> None:
        self._name = name
        self._on_connection = on_connection
        self._on_shortage = on_shortage
        self._closing = threading.Event()
        self._socket: socket.socket | None = None
        self._wake: tuple[socket.socket, socket.socket] | None = None
        self._thread: threading.Thread | None = None

    @property
    def is_open(self) -> bool:
        """Whether it listens."""
        return self._socket is not None

    def open(self, address: tuple[str, int]) -> int:
        """Listen, and return the port number. Connections wait until `start`. Raises TransportError."""
        self._socket = sockets.listen(address)
        self._socket.setblocking(False)
        try:
            self._wake = socket.socketpair()
        except OSError as error:
            self.close()
            raise ResourceExhaustedError.of(error) or TransportError(sockets.reason(error)) from error
        self._closing.clear()
        return int(self._socket.getsockname()[1])

    def start(self) -> None:
        """Accept connections from now on."""
        self._thread = threading.Thread(target=self._accept, name=f"yarp {self._name}", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Stop accepting connections, but keep the address. Waits for the thread."""
        self._closing.set()
        if self._wake:
            self._wake[1].send(b"x")
        if self._thread:
            self._thread.join(10)

    def close(self) -> None:
        """Give the address up. May be called twice."""
        for sock in (self._socket, *(self._wake or ())):
            if sock is not None:
                sock.close()
        self._socket = self._wake = self._thread = None

    def _accept(self) -> None:
        listener, wake = self._socket, self._wake
        assert listener and wake
        with _Selector() as selector:
            selector.register(listener, selectors.EVENT_READ)
            selector.register(wake[0], selectors.EVENT_READ)
            while not self._closing.is_set():
                selector.select()
                try:
                    sock, address = listener.accept()
                except OSError as error:
                    if failure := ResourceExhaustedError.of(error):
                        self._pause(str(failure))
                    continue
                sock.setblocking(True)
                try:
                    self._on_connection(sock, address[0])
                except ResourceExhaustedError as error:
                    self._pause(str(error))

    def _pause(self, reason: str) -> None:
        self._on_shortage(reason)
        self._closing.wait(_PAUSE_SECONDS)

"""Waiting for packets or for time to pass, which another thread can end.

`select.select` raises for descriptors from 1024 on, and Windows has no `poll`; `selectors` knows what a
system has.
"""

from __future__ import annotations

import select
import selectors
import socket
import sys
import threading
from collections.abc import Callable, Iterable


class Waits:
    """The waits of one thread, for packets or for time to pass, which another thread can end."""

    def __init__(self) -> None:
        self._over = threading.Lock()
        "Taken until `end`."
        self._over.acquire()
        self._bell, self._button = socket.socketpair()

    def end(self) -> None:
        """Let every wait return at once from now on. Any thread, once."""
        self._over.release()
        self._button.send(b"\0")

    def close(self) -> None:
        """Close the sockets that wake the thread."""
        self._bell.close()
        self._button.close()

    def rest(self, seconds: float) -> None:
        """Let time pass."""
        if self._over.acquire(timeout=seconds):
            self._over.release()

    def readable(self, receiver: socket.socket, timeout: float) -> bool:
        """Return whether the socket has something to read, after at most `timeout` seconds."""
        return receiver in readable([receiver, self._bell], timeout)

    def waiter(self, sockets: Iterable[socket.socket]) -> Callable[[float], list[int]]:
        """Return a function that waits for at most the given seconds and returns the readable descriptors.

        For a loop: the sockets are registered once, and nothing must be closed afterwards. Not on Windows.
        """
        if sys.platform == "win32":
            raise OSError("Windows has no poll")
        poll, bell = select.poll(), self._bell.fileno()
        for each in (*sockets, self._bell):
            poll.register(each, select.POLLIN)
        return lambda timeout: [ready for ready, _ in poll.poll(1000 * timeout) if ready != bell]


def readable(sockets: Iterable[socket.socket], timeout: float) -> list[socket.socket]:
    """Return those sockets that have something to read, after at most `timeout` seconds."""
    with selectors.DefaultSelector() as selector:
        for each in sockets:
            selector.register(each, selectors.EVENT_READ, each)
        return [key.data for key, _ in selector.select(timeout)]

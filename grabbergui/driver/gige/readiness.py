"""Waiting for sockets however many files the program has open.

`select.select` raises for descriptors from 1024 on, and Windows has no `poll`; `selectors` knows what a
system has.
"""

from __future__ import annotations

import select
import selectors
import socket
import sys
from collections.abc import Callable, Iterable


def readable(sockets: Iterable[socket.socket], timeout: float) -> list[socket.socket]:
    """Return those sockets that have something to read, after at most `timeout` seconds."""
    with selectors.DefaultSelector() as selector:
        for each in sockets:
            selector.register(each, selectors.EVENT_READ, each)
        return [key.data for key, _ in selector.select(timeout)]


def waiter(sockets: Iterable[socket.socket]) -> Callable[[float], list[int]]:
    """Return a function that waits up to so many seconds and returns the descriptors that can be read.

    For a loop: the sockets are registered once, and nothing must be closed afterwards. Not on Windows.
    """
    if sys.platform == "win32":
        raise OSError("Windows has no poll")
    poll = select.poll()
    for each in sockets:
        poll.register(each, select.POLLIN)
    return lambda timeout: [descriptor for descriptor, _ in poll.poll(1000 * timeout)]

"""The peer whose request is being executed: set by a network's server for the thread that answers it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_requester: ContextVar[str] = ContextVar("requester", default="")


@contextmanager
def requested_by(name: str) -> Iterator[None]:
    """Name the program whose request is answered within the block, on this thread."""
    token = _requester.set(name)
    try:
        yield
    finally:
        _requester.reset(token)


def requester() -> str:
    """Return the name of the program that asked; empty if it is not known, as on ROS 2, or there is none."""
    return _requester.get()

"""The end of the program: everything that has to be waited for, within one time."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from typing import TypeAlias

Wait: TypeAlias = tuple[str, Callable[[float], bool]]
"""A name for the log, and a function that waits at most so many seconds and returns whether all is done."""


def wait_for_all(waits: Iterable[Wait], timeout: float) -> list[str]:
    """Call every wait once, together for at most `timeout` seconds; return what did not end."""
    deadline = time.monotonic() + timeout
    return [name for name, wait in waits if not wait(max(0.0, deadline - time.monotonic()))]

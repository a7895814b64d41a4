"""The lock around a node map, which also reports what changed while it was held."""

from __future__ import annotations

import threading
from collections.abc import Callable
from types import TracebackType


class MapLock:
    """A reentrant lock that collects the names of changed features, and reports them once it is free.

    The report is made outside the lock, on the thread that held it, also after an exception.
    """

    def __init__(self, on_change: Callable[[frozenset[str]], None]) -> None:
        self.on_change = on_change
        self.changed: set[str] = set()
        "Features that changed since the lock was taken. Only for whoever holds it."
        self._lock = threading.RLock()
        self._depth = 0

    def __enter__(self) -> None:
        self._lock.acquire()
        self._depth += 1

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        changed: frozenset[str] = frozenset()
        self._depth -= 1
        if self._depth == 0 and self.changed:
            changed = frozenset(self.changed)
            self.changed.clear()
        self._lock.release()
        if changed:
            self.on_change(changed)

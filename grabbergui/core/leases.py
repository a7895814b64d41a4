"""Memory that is lent until the last array over it is gone."""

from __future__ import annotations

import weakref
from collections import deque
from typing import Any, Generic, TypeVar

Lent = TypeVar("Lent")


class _Lease(weakref.ref[Any]):
    __slots__ = ("lent",)
    lent: Any


class Leases(Generic[Lent]):
    """Remembers what is lent, until the object that keeps it is collected.

    The return is recorded by a built-in function: no Python code runs while the object is collected. Such
    code could receive the KeyboardInterrupt of a Ctrl-C, and Python discards every exception raised there.

    `lend` and `returned` need a lock of the caller's; objects may be collected on any thread.
    """

    def __init__(self) -> None:
        self._leases: dict[int, _Lease] = {}
        "By id, for a weak reference that is gone calls nothing."
        self._gone: deque[weakref.ref[Any]] = deque()

    def lend(self, keeper: object, lent: Lent) -> None:
        """Lend something as long as `keeper` lives, which must not keep this object."""
        lease = _Lease(keeper, self._gone.append)
        lease.lent = lent
        self._leases[id(lease)] = lease

    def returned(self) -> list[Lent]:
        """Return what came back since the last call."""
        back = []
        while self._gone:
            back.append(self._leases.pop(id(self._gone.popleft())).lent)
        return back

    def __len__(self) -> int:
        """Number of things lent, as of the last `returned`."""
        return len(self._leases)

"""The multicast groups to which a port sends: one for all readers on a network, from the name server.

The name server lists each group under a name such as `/tmp/port/1` until it is unregistered. Several readers
share one group, so only one of their outputs sends; when it ends, the next one does.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Final

from grabbergui.core.errors import GrabberError
from grabbergui.net.yarp.os.name_client import NameClient

log = logging.getLogger(__name__)

FALLBACK: Final = ("224.3.1.1", 11000)
"""The group where no name server gives one, as in YARP."""

Key = tuple[str, str]


class Membership:
    """An output's share in a group. Any thread."""

    def __init__(self, address: tuple[str, int], name: str, leave: Callable[[Membership], None]) -> None:
        self.address = address
        "The group's, and its UDP port."
        self.name = name
        "The group's at the name server; empty without one."
        self.sends = False
        "Whether this output sends to the group, of all that share it."
        self._leave = leave

    def leave(self) -> None:
        """Stop sharing the group. May be called twice; returns immediately."""
        self._leave(self)


class MulticastGroups:
    """The groups of one port. Any thread."""

    def __init__(self, port: str, names: NameClient | None) -> None:
        self._port = port
        self._names = names
        self._lock = threading.Lock()
        self._members: dict[Key, list[Membership]] = {}
        "By the address from which we send, and the carrier with its modifiers; none is empty."
        self._leaving: list[threading.Thread] = []

    def join(self, host: str, carrier: str) -> Membership:
        """Share the group for readers that are reached from our address `host`. Never raises.

        `carrier` has its modifiers: readers who ask for other images need a group of their own.
        """
        with self._lock:
            members = self._members.setdefault((host, carrier), [])
            address, name = (members[0].address, members[0].name) if members else self._register()
            member = Membership(address, name, self._leave)
            member.sends = not members
            members.append(member)
            return member

    def close(self, seconds: float) -> None:
        """Wait until the groups that were left are unregistered, `seconds` at most."""
        deadline = time.monotonic() + seconds
        for thread in self._leaving:
            thread.join(max(0.0, deadline - time.monotonic()))
        self._leaving = [thread for thread in self._leaving if thread.is_alive()]

    def _leave(self, member: Membership) -> None:
        with self._lock:
            key = next((key for key, members in self._members.items() if member in members), None)
            if key is None:
                return
            member.sends = False
            self._members[key].remove(member)
            if self._members[key]:
                self._members[key][0].sends = True
                return
            del self._members[key]
        # A name server that hangs must not hold up the end of a connection.
        thread = threading.Thread(
            target=self._unregister, args=[member.name], name=f"yarp {self._port} leaves a group", daemon=True
        )
        with suppress(RuntimeError):  # the program ends, or has no threads left
            thread.start()
            self._leaving = [*(other for other in self._leaving if other.is_alive()), thread]

    def _register(self) -> tuple[tuple[str, int], str]:
        """Return a new group's address and name."""
        if self._names is not None:
            try:
                contact = self._names.register("...", "mcast")
                self._names.set_property(self._port, "owns", contact.name)
            except GrabberError as error:
                log.warning("%s: sends to the group %s:%d: %s", self._port, *FALLBACK, error)
            else:
                return contact.address, contact.name
        return FALLBACK, ""

    def _unregister(self, name: str) -> None:
        if self._names is not None and name:
            try:
                self._names.unregister(name)
            except GrabberError as error:
                log.debug("%s: group %s stays registered: %s", self._port, name, error)

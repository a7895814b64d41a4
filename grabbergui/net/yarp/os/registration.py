"""A port's name at the name server, kept registered."""

from __future__ import annotations

import logging
import os
import threading
import time
from collections.abc import Callable
from typing import Final

from grabbergui.core.errors import GrabberError, SourceNotFoundError, TransportError
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os.contact import Contact
from grabbergui.net.yarp.os.link import describes_itself
from grabbergui.net.yarp.os.name_client import NameClient

log = logging.getLogger(__name__)

KEEP_SECONDS: Final = 5.0
"""Seconds between two checks whether the name server still knows a port."""

HOLDER_SECONDS: Final = 1.0
"""Longest wait for the port that has our name already: one that does not answer loses it."""

LONGEST_PAUSE: Final = 300.0
"""Longest pause in seconds between two registrations of a disputed name."""


GIVE_UP_SECONDS: Final = 2.0
"""Longest wait for a name server when a port closes; one that hangs must not hold up the end of a program."""


class Registration:
    """The name of one port, from when it opens until it closes."""

    def __init__(
        self, contact: Contact, names: NameClient, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._contact = contact
        self._names = names
        self._clock = clock
        self._closing = threading.Event()
        self._given_up = 0.0
        self._thread = threading.Thread(target=self._run, name=f"yarp {contact.name} name", daemon=True)

    def open(self) -> None:
        """Register, and keep it so; if it fails, nothing is registered.

        Raises SourceUnavailableError, TransportError if another port has the name and answers.
        """
        try:
            self._require_free()
            self._register()
        except GrabberError:
            self.give_up()
            self._thread.start()
            self.close()
            raise
        self._thread.start()

    def announce(self) -> None:
        """Register the port as listening. Never raises."""
        self._quietly(self._names.announce, self._contact.name)

    def give_up(self) -> None:
        """Begin to give the name up. Never waits."""
        if not self._closing.is_set():
            self._given_up = time.monotonic()
            self._closing.set()

    def close(self) -> None:
        """Give the name up, unless another port has it by now. Never raises.

        If the name server hangs, waits no longer than `GIVE_UP_SECONDS` after `give_up`.
        """
        self.give_up()
        self._thread.join(max(0.0, self._given_up + GIVE_UP_SECONDS - time.monotonic()))

    def _run(self) -> None:
        self._keep()
        self._quietly(self._unregister)

    def _unregister(self) -> None:
        if self._names.query(self._contact.name).address == self._contact.address:
            self._names.unregister(self._contact.name)

    def _require_free(self) -> None:
        """Raise TransportError if another port has this name. One that is gone left it behind."""
        try:
            holder = self._names.query(self._contact.name)
        except SourceNotFoundError:
            return
        if holder.address == self._contact.address:
            return
        if not describes_itself(holder.name, holder.address, self._names.key, HOLDER_SECONDS):
            log.info("%s: taken over from %s:%d, where it does not answer", holder.name, *holder.address)
            return
        process = self._names.property_of(holder.name, "process")
        raise TransportError(
            f"{holder.name} is taken by the port at {holder.host}:{holder.port}"
            f"{f', of process {process}' if process else ''}; end that program, or choose another name"
        )

    def _register(self) -> None:
        contact = self._contact
        self._names.register(contact.name, "tcp", contact.host, contact.port)
        for key in ("offers", "accepts"):
            self._names.set_property(contact.name, key, *wire.CARRIERS)
        self._names.set_property(contact.name, "ips", contact.host)
        self._names.set_property(contact.name, "process", str(os.getpid()))

    def _keep(self) -> None:
        """Register the name again when the name server forgot it or another port took it."""
        name, unreachable = self._contact.name, False
        pause, since = KEEP_SECONDS, self._clock()
        while not self._closing.wait(KEEP_SECONDS):
            try:
                known = self._names.query(name)
                unreachable = False
                if self._clock() - since < pause:
                    continue
                since = self._clock()
                if known.address == self._contact.address:
                    pause = max(KEEP_SECONDS, pause / 2)
                    continue
                # Back off: two ports with one name must not load the name server.
                pause = min(2 * pause, LONGEST_PAUSE)
                log.warning(
                    "%s: %s:%d took this name at the name server; it is registered again, and if it is taken "
                    "again, in %g s",
                    *(name, *known.address, pause),
                )
                self._register()
            except SourceNotFoundError:
                if self._quietly(self._register):
                    log.info("%s: registered again", name)
            except GrabberError as error:
                if not unreachable:
                    log.warning("%s: %s", name, error)
                unreachable = True

    def _quietly(self, action: Callable[..., object], *arguments: str) -> bool:
        """Do something that may fail; return whether it succeeded."""
        try:
            action(*arguments)
        except GrabberError as error:
            log.debug("%s: %s", self._contact.name, error)
            return False
        return True

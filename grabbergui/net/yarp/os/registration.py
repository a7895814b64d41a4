"""A port's entry with the name server, and a thread that keeps it there."""

from __future__ import annotations

import logging
import os
import threading
from collections.abc import Callable
from typing import Final

from grabbergui.core.errors import GrabberError, SourceNotFoundError
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.names import Contact

log = logging.getLogger(__name__)

KEEP_SECONDS: Final = 5.0
"""How often a port asks whether the name server still knows it."""

LONGEST_WAIT: Final = 300.0
"""Between two announcements of a name that somebody else takes again and again."""


class Registration:
    """The name of one port, from when it opens until it closes."""

    def __init__(self, contact: Contact, names: NameClient) -> None:
        self._contact = contact
        self._names = names
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._keep, name=f"yarp {contact.name} name", daemon=True)

    def open(self) -> None:
        """Register, and keep it so. Raises SourceUnavailableError; the name is free again then."""
        try:
            self._register()
        except GrabberError:
            self._quietly(self._names.unregister, self._contact.name)
            raise
        self._thread.start()

    def announce(self) -> None:
        """Tell that the port listens. Never raises."""
        self._quietly(self._names.announce, self._contact.name)

    def close(self) -> None:
        """Give the name up. Never raises."""
        self._closing.set()
        self._thread.join(10)
        self._quietly(self._names.unregister, self._contact.name)

    def _register(self) -> None:
        contact = self._contact
        self._names.register(contact.name, "tcp", contact.host, contact.port)
        for key in ("offers", "accepts"):
            self._names.set_property(contact.name, key, *wire.CARRIERS)
        self._names.set_property(contact.name, "ips", contact.host)
        self._names.set_property(contact.name, "process", str(os.getpid()))

    def _keep(self) -> None:
        """Announce the name again when the name server forgot it or another port took it."""
        name, unreachable, wait = self._contact.name, False, KEEP_SECONDS
        while not self._closing.wait(wait):
            try:
                known = self._names.query(name)
                unreachable = False
                if known.address == self._contact.address:
                    wait = max(KEEP_SECONDS, wait / 2)
                    continue
                # The longer the dispute, the rarer: two ports of one name must not load the name server.
                wait = min(2 * wait, LONGEST_WAIT)
                log.warning(
                    "%s: %s:%d took this name at the name server; it is registered again, and looked after "
                    "in %g s",
                    *(name, *known.address, wait),
                )
                self._register()
            except SourceNotFoundError:
                self._quietly(self._register)
                log.info("%s: registered again", name)
            except GrabberError as error:
                if not unreachable:
                    log.warning("%s: %s", name, error)
                unreachable = True

    def _quietly(self, action: Callable[..., object], *arguments: str) -> None:
        try:
            action(*arguments)
        except GrabberError as error:
            log.debug("%s: %s", self._contact.name, error)

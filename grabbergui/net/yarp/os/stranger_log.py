"""The log about peers that misbehave, which they cannot flood."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable

from grabbergui.net.yarp.os.connection_limits import QUIET_SECONDS

log = logging.getLogger(__name__)


class StrangerLog:
    """Lines about strangers, a few a minute however many come. Any thread.

    The rest is logged one level below.
    """

    def __init__(
        self, port: str, clock: Callable[[], float] = time.monotonic, *, level: int = logging.WARNING
    ) -> None:
        self._port = port
        self._clock = clock
        self._level = level
        self._next = 0.0
        self._suppressed = 0

    def warn(self, text: str) -> None:
        """Log it; a level below if another line was logged shortly before."""
        now = self._clock()
        if now < self._next:
            self._suppressed += 1
            log.log(self._level - 10, "%s: %s", self._port, text)
            return
        more = f" ({self._suppressed} more since the last such line)" if self._suppressed else ""
        self._next, self._suppressed = now + QUIET_SECONDS, 0
        log.log(self._level, "%s: %s%s", self._port, text, more)

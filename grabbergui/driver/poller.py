"""Polls the values that a camera's description says to poll."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable

from grabbergui.core.errors import GrabberError, TransportError

log = logging.getLogger(__name__)

POLL_PERIOD = 0.1
"""Seconds between checks of GenApi's polling times and of values under an automatic mode."""


class Poller:
    """Calls a function every POLL_PERIOD on its own thread until stopped."""

    def __init__(self, function: Callable[[], None]) -> None:
        self._function = function
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._run, name="feature-poll", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End the thread and wait for it."""
        self._stopped.set()
        if self._thread is not threading.current_thread():
            self._thread.join()

    def _run(self) -> None:
        while not self._stopped.wait(POLL_PERIOD):
            try:
                self._function()
            except TransportError as error:
                log.debug("polling features: %s", error)
            except GrabberError as error:
                log.info("polling features: %s", error)

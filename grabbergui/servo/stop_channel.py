"""A way to stop the robot without the servo program: a channel, and the thread that keeps it connected."""

from __future__ import annotations

import threading
import time
from abc import ABC, abstractmethod

CHECK_S, RETRY_S = 1.0, 0.1
"""Seconds between two checks of a channel that works, and of one that does not."""


class Channel(ABC):
    """One way to stop a robot. Used by one thread."""

    name = ""
    "Its port or topic, for messages."

    @abstractmethod
    def prepare(self) -> None:
        """Connect unless connected, and check that a stop would arrive. Raises GrabberError."""

    @abstractmethod
    def stop(self) -> None:
        """Send the stop, and wait for the answer if the protocol has one. Raises GrabberError."""

    @abstractmethod
    def close(self) -> None:
        """Disconnect for good. Never raises."""

    def reset(self) -> None:
        """Drop a connection that failed, so that the next call connects again. Never raises."""
        self.close()


class ChannelThread:
    """Keeps one channel connected and sends the stop there, on a thread of its own. `stop` never waits.

    A stop that fails is tried again until it gets through; `close` gives it one more try.
    """

    def __init__(self, channel: Channel) -> None:
        self.problem = f"{channel.name} is not connected yet"
        "Why a stop would not arrive; empty when it would."
        self._channel = channel
        self._asked = self._done = 0
        self._closing = False
        self._wake = threading.Event()
        self._thread = threading.Thread(target=self._run, name=channel.name, daemon=True)
        self._thread.start()

    @property
    def stopping(self) -> bool:
        """Whether a stop has not been delivered yet."""
        return self._done < self._asked

    def stop(self) -> None:
        """Send the stop as soon as possible."""
        self._asked += 1
        self._wake.set()

    def close(self) -> None:
        """Begin to disconnect; does not wait."""
        self._closing = True
        self._wake.set()

    def join(self, deadline: float) -> None:
        """Wait until it is disconnected, or until a moment on the monotonic clock."""
        self._thread.join(max(0.0, deadline - time.monotonic()))

    def _run(self) -> None:
        closing = False
        while not closing:
            self._wake.clear()
            closing = self._closing  # before `asked`: a stop that was asked for before `close` is still sent
            asked = self._asked
            try:
                if asked > self._done:
                    self._channel.stop()
                    self._done = asked
                elif not closing:
                    self._channel.prepare()
                self.problem = ""
            except Exception as error:  # whatever a network's library raises, the stop must be tried again
                name, text = self._channel.name, str(error)
                self.problem = text if text.startswith(name) else f"{name}: {text}"
                self._channel.reset()
            if not closing:
                self._wake.wait(RETRY_S if self.problem else CHECK_S)
        self._channel.close()

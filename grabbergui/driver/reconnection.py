"""A frame grabber whose camera is opened again after a loss."""

from __future__ import annotations

import logging
import threading
from abc import abstractmethod
from collections.abc import Mapping
from types import TracebackType

from typing_extensions import override

from grabbergui.core.errors import DeviceLostError, GrabberError, OtherCameraError
from grabbergui.core.features import FeatureValue
from grabbergui.core.grabber import ConnectionState, FrameGrabber
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.settings import SettingKey, return_text

log = logging.getLogger(__name__)

RECONNECT_PERIOD = 0.5
"""Seconds between attempts to open a camera that was lost."""


class ReconnectingGrabber(FrameGrabber):
    """Opens a lost camera again as soon as it answers, on a thread of its own; reports its loss and return.

    A subclass calls `_begin_opening` and `_finish_opening` around its own opening, `_lose` from any thread
    when the camera is lost, and `_stop_reconnecting` and `_end_connection` when it closes.
    """

    def __init__(self, info: DeviceInfo) -> None:
        super().__init__(info)
        self._closed = threading.Event()
        self._closed.set()
        self._reconnecting: threading.Thread | None = None
        self._losses = threading.Lock()
        "Never held during device calls: closing the device joins the threads that report losses."
        self._lost_while_opening = ""
        "Reason for a loss during opening or reconnecting; empty if there was none."
        self._loss = ""
        "Reason for the current loss; empty while connected."
        self._explaining_loss = _ExplainedLoss(self)

    @property
    @override
    def lost(self) -> str:
        return self._loss

    @abstractmethod
    def _known_settings(self) -> dict[SettingKey, FeatureValue]:
        """Return the last known values of settings that this program did not write."""

    @abstractmethod
    def _disconnect(self) -> None:
        """Close the device, which may be closed already."""

    @abstractmethod
    def _restore(self, known: Mapping[SettingKey, FeatureValue]) -> tuple[list[str], list[str]]:
        """Open the device, restore its settings, and resume its stream. Raises GrabberError.

        Return what could not be set, and which of the `known` settings others changed, one sentence each.
        """

    def _begin_opening(self) -> None:
        self._lost_while_opening = self._loss = ""

    def _finish_opening(self) -> None:
        """From now on, a loss is followed by attempts. Raises DeviceLostError if there was one already."""
        with self._losses:
            if self._lost_while_opening:
                raise DeviceLostError(f"{self.info.title} was lost while it was opened")
            self._closed.clear()

    def _lose(self, reason: str) -> None:
        log.warning("%s: %s", self.info.uri, reason)
        self._loss = reason
        self.connection_changed.emit(ConnectionState.LOST, reason)
        with self._losses:
            if self._closed.is_set() or self._reconnecting is not None:
                self._lost_while_opening = reason
                return
            name = f"reconnect {self.info.uri}"
            self._reconnecting = threading.Thread(target=self._reconnect, name=name, daemon=True)
            self._reconnecting.start()  # within the lock: closing joins it

    def _stop_reconnecting(self) -> bool:
        """Begin no further attempt; return whether one may be in progress, which holds the lock."""
        self._closed.set()
        return self._reconnecting is not None

    def _end_connection(self) -> threading.Thread | None:
        """Forget the loss; return the thread of the attempts, to be joined without the lock."""
        with self._losses:
            thread, self._reconnecting = self._reconnecting, None
        self._loss = ""
        return thread if thread is not threading.current_thread() else None

    def _reconnect(self) -> None:
        """Retry until the camera answers or is closed. Refuse another one in its place; report it once."""
        reported = ""
        with self._lock:
            known = self._known_settings()
        while not self._closed.wait(RECONNECT_PERIOD):
            with self._lock:
                if self._closed.is_set():
                    return
                try:
                    self._disconnect()
                    self._lost_while_opening = ""  # what was reported so far was lost with the connection
                    problems, changed = self._restore(known)
                except GrabberError as error:
                    log.info("%s is not back yet: %s", self.info.uri, error)
                    if isinstance(error, OtherCameraError) and str(error) != reported:
                        reported = self._loss = str(error)
                        log.warning("%s: %s", self.info.uri, reported)
                        self.connection_changed.emit(ConnectionState.LOST, reported)
                    continue
                with self._losses:
                    if self._lost_while_opening:
                        continue
                names = frozenset(description.name for description in self.feature_tree().descriptions())
            # `close` joins this thread, so these reports precede CLOSED.
            self.unlike_before, self.changed_meanwhile = tuple(problems), tuple(changed)
            self._loss = ""
            # A warning like the loss itself: a server's log has no other sign of the return.
            how = return_text(problems, changed)
            log.warning("%s: back, %s", self.info.uri, how)
            self.connection_changed.emit(ConnectionState.OPEN, how)
            self.features_changed.emit(names)
            with self._losses:
                if not self._lost_while_opening:
                    self._reconnecting = None
                    return
            with self._lock:
                known = self._known_settings()
            # This loss may have been reported before OPEN, so report it again.
            self._loss = self._lost_while_opening
            self.connection_changed.emit(ConnectionState.LOST, self._lost_while_opening)


class _ExplainedLoss:
    """Adds the reason of the loss to errors while the device is closed between reconnect attempts.

    A class, for a generator would cost each write of a slider four more calls.
    """

    def __init__(self, grabber: FrameGrabber) -> None:
        self._grabber = grabber

    def __enter__(self) -> None:
        pass

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        loss = self._grabber.lost
        if isinstance(error, DeviceLostError) and loss and loss not in str(error):
            raise DeviceLostError(f"{self._grabber.info.title} is lost: {loss}") from error

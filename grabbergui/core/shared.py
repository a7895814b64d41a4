"""One open grabber for several users within a process: the window beside the network servers."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from grabbergui.core.calibration import Calibration
from grabbergui.core.features import Category, Feature, FeatureValue
from grabbergui.core.frame_queue import FrameQueue
from grabbergui.core.grabber import Access, ConnectionState, DeviceEvent, FrameGrabber, StreamStatistics
from grabbergui.core.selection import Selectors, SettingKey, WriteResult


class SharedGrabber(FrameGrabber):
    """Another handle on a grabber that somebody else opened, and closes.

    Everything is passed on, changes come from either side, but closing this handle only lets go of it. Its
    queues are closed with it. Stopping the stream stops it for all, as on the camera itself.
    """

    shared = True

    def __init__(self, grabber: FrameGrabber) -> None:
        super().__init__(grabber.info)
        self._grabber = grabber
        self._queues: list[FrameQueue] = []
        self._opening = threading.Lock()
        "Of the list of queues, as any thread may open one."

    def open(self, access: Access = Access.CONTROL) -> None:
        """Listen to the grabber; it is open already."""
        # Not to `emit` itself: psygnal would try it with as many arguments as it takes to fail.
        self._grabber.features_changed.connect(self._on_features_changed)
        self._grabber.connection_changed.connect(self._on_connection_changed)
        self._grabber.noticed.connect(self._on_noticed)
        self._grabber.event_received.connect(self._on_event)
        self.connection_changed.emit(ConnectionState.OPEN, "")

    def close(self) -> None:
        """See FrameGrabber."""
        self._grabber.features_changed.disconnect(self._on_features_changed, missing_ok=True)
        self._grabber.connection_changed.disconnect(self._on_connection_changed, missing_ok=True)
        self._grabber.noticed.disconnect(self._on_noticed, missing_ok=True)
        self._grabber.event_received.disconnect(self._on_event, missing_ok=True)
        with self._opening:
            queues, self._queues = self._queues, []
        for queue in queues:
            queue.close()

    @property
    def access(self) -> Access:
        """See FrameGrabber."""
        return self._grabber.access

    def feature_tree(self) -> Category:
        """See FrameGrabber."""
        return self._grabber.feature_tree()

    def has_feature(self, name: str) -> bool:
        """See FrameGrabber."""
        return self._grabber.has_feature(name)

    def feature(self, name: str) -> Feature:
        """See FrameGrabber."""
        return self._grabber.feature(name)

    def write_feature(self, name: str, value: FeatureValue) -> Feature:
        """See FrameGrabber."""
        return self._grabber.write_feature(name, value)

    @property
    def selectors(self) -> Selectors:
        """See FrameGrabber."""
        return self._grabber.selectors

    def setting(self, name: str) -> SettingKey:
        """See FrameGrabber."""
        return self._grabber.setting(name)

    def read_setting(self, key: SettingKey) -> Feature:
        """See FrameGrabber."""
        return self._grabber.read_setting(key)

    def write_setting(self, key: SettingKey, value: FeatureValue) -> WriteResult:
        """See FrameGrabber."""
        return self._grabber.write_setting(key, value)

    def execute_setting(self, key: SettingKey) -> None:
        """See FrameGrabber."""
        self._grabber.execute_setting(key)

    @contextmanager
    def exclusive(self, selectors: Iterable[str] = ()) -> Iterator[None]:
        """See FrameGrabber."""
        with self._grabber.exclusive(selectors):
            yield

    def pauses_for(self, name: str) -> bool:
        """See FrameGrabber."""
        return self._grabber.pauses_for(name)

    def execute(self, name: str) -> None:
        """See FrameGrabber."""
        self._grabber.execute(name)

    def start(self, *, keep_trigger: bool = False) -> None:
        """See FrameGrabber."""
        self._grabber.start(keep_trigger=keep_trigger)

    def stop(self) -> None:
        """See FrameGrabber."""
        self._grabber.stop()

    @property
    def streaming(self) -> bool:
        """See FrameGrabber."""
        return self._grabber.streaming

    def statistics(self) -> StreamStatistics:
        """See FrameGrabber."""
        return self._grabber.statistics()

    def calibration(self) -> Calibration | None:
        """See FrameGrabber."""
        return self._grabber.calibration()

    def open_queue(self, depth: int = 2) -> FrameQueue:
        """See FrameGrabber."""
        queue = self._grabber.open_queue(depth)
        with self._opening:
            self._queues = [*(q for q in self._queues if not q.closed), queue]
        return queue

    def _on_features_changed(self, names: frozenset[str]) -> None:
        self.features_changed.emit(names)

    def _on_noticed(self, message: str) -> None:
        self.noticed.emit(message)

    def _on_event(self, event: DeviceEvent) -> None:
        self.event_received.emit(event)

    def _on_connection_changed(self, state: ConnectionState, reason: str) -> None:
        self.info, self.unlike_before = self._grabber.info, self._grabber.unlike_before
        self.connection_changed.emit(state, reason)

"""What grabbers of remote cameras have in common, whichever network they are on."""

from __future__ import annotations

import threading
from abc import abstractmethod
from typing import Generic, Protocol, TypeVar

from grabbergui.core.errors import FeatureAccessError
from grabbergui.core.features import Category, Feature, FeatureValue
from grabbergui.core.grabber import Access, DeviceInfo, FrameGrabber, StreamStatistics


class RemoteFeatures(Protocol):
    """A remote camera's features, however they cross the wire. One thread at a time."""

    tree: Category

    def has(self, name: str) -> bool:
        """Whether there is such a feature."""

    def read(self, name: str) -> Feature:
        """The feature as the server has it now."""

    def write(self, name: str, value: FeatureValue) -> Feature:
        """Set it and read it back."""

    def execute(self, name: str) -> None:
        """Run a command."""


class RemoteStream(Protocol):
    """Pictures coming in."""

    def close(self) -> None:
        """Stop."""

    def statistics(self) -> StreamStatistics:
        """A snapshot. Any thread; also after `close`."""


StreamType = TypeVar("StreamType", bound=RemoteStream)


class RemoteGrabber(FrameGrabber, Generic[StreamType]):
    """Features asked of the other end, one request at a time; pictures that come while streaming."""

    shared = True

    def __init__(self, info: DeviceInfo) -> None:
        super().__init__(info)
        # Over every use of the link: the window's thread and the watcher both ask the other end.
        self._lock = threading.RLock()
        self._stream: StreamType | None = None
        self._statistics = StreamStatistics()

    @abstractmethod
    def _known(self) -> RemoteFeatures:
        """The features, also while the other end is away. Raises where it was never open."""

    def _connected(self) -> RemoteFeatures:
        """The features of an other end that is there. Raises where it is not."""
        return self._known()

    # -- features --------------------------------------------------------------------------------
    def feature_tree(self) -> Category:
        """See FrameGrabber."""
        return self._known().tree

    def has_feature(self, name: str) -> bool:
        """See FrameGrabber."""
        return self._known().has(name)

    def feature(self, name: str) -> Feature:
        """See FrameGrabber."""
        self._require(name)
        with self._lock:
            return self._connected().read(name)

    def write_feature(self, name: str, value: FeatureValue) -> Feature:
        """See FrameGrabber."""
        self._require_control(name)
        with self._lock:
            return self._connected().write(name, value)

    def execute(self, name: str) -> None:
        """See FrameGrabber."""
        self._require_control(name)
        with self._lock:
            self._connected().execute(name)

    def _require_control(self, name: str) -> None:
        self._require(name)
        if self.access is Access.MONITOR:
            raise FeatureAccessError(f"{name}: {self.info.title} was opened for reading only", name)

    # -- acquisition -----------------------------------------------------------------------------
    def stop(self) -> None:
        """Let no more pictures come; the remote camera itself is not touched."""
        with self._lock:
            stream, self._stream = self._stream, None
            if stream is not None:
                stream.close()
                self._statistics = stream.statistics()

    @property
    def streaming(self) -> bool:
        """See FrameGrabber."""
        return self._stream is not None

    def statistics(self) -> StreamStatistics:
        """See FrameGrabber."""
        stream = self._stream
        return stream.statistics() if stream is not None else self._statistics

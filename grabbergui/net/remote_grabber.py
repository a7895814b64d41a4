"""The grabber of a remote camera, on any network."""

from __future__ import annotations

import logging
from abc import abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Generic, Protocol, TypeVar

from typing_extensions import override

from grabbergui.core.errors import FeatureAccessError, FeatureError
from grabbergui.core.features import Category, Feature, FeatureValue, format_value
from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.core.grabber import Access, ConnectionState, FrameGrabber
from grabbergui.core.identity import DeviceInfo, require_same
from grabbergui.core.settings import SettingKey, WriteResult, return_text, same_value
from grabbergui.core.sfnc import Companions, regulating
from grabbergui.net.tree import TreeFeatures

MOST_SEEN = 500
"Settings that are compared after a reconnection; each costs a request."

READS_AT_ONCE = 10
"""Features read by one request. A write in the meantime waits for its answer."""

log = logging.getLogger(__name__)


class RemoteFeatures(Protocol):
    """A remote camera's features, over any protocol. One thread at a time."""

    tree: Category

    def has(self, name: str) -> bool:
        """Return whether there is such a feature."""

    def read(self, name: str) -> Feature:
        """Return the feature as the server has it now."""

    def write(self, name: str, value: FeatureValue) -> Feature:
        """Set it and read it back."""

    def execute(self, name: str) -> None:
        """Run a command."""


class RemoteStream(Protocol):
    """A stream of incoming frames."""

    def close(self) -> None:
        """Stop."""

    def statistics(self) -> StreamStatistics:
        """Return a snapshot. Any thread; also after `close`."""

    def silence(self) -> str:
        """Return from where images should arrive, as display text. Any thread."""


def reached_by(link: DeviceInfo, camera: DeviceInfo) -> DeviceInfo:
    """Return the camera that the other end describes, with the way by which it is reached here."""
    return replace(
        camera, uri=link.uri, bus=link.bus, address=link.address, interface=link.interface, note=""
    )


StreamType = TypeVar("StreamType", bound=RemoteStream)


class RemoteGrabber(FrameGrabber, Generic[StreamType]):
    """Reads and writes features by one request at a time, and receives frames while streaming."""

    shared = True

    def __init__(self, info: DeviceInfo) -> None:
        super().__init__(info)
        self._seen: dict[SettingKey, FeatureValue] = {}
        "Settings as last read or written, for a comparison after an interruption."
        self._stream: StreamType | None = None
        self._stream_lock = self._lock
        "Guards the stream."
        self._statistics = StreamStatistics()
        self._lost = ""
        self._access = Access.CONTROL

    @abstractmethod
    def _known(self) -> RemoteFeatures:
        """Return the features, also while the other end does not answer. Raises if it was never open."""

    def _connected(self) -> RemoteFeatures:
        """Return the features. Raises while the other end does not answer."""
        return self._known()

    @property
    @override
    def access(self) -> Access:
        return self._access

    @property
    @override
    def lost(self) -> str:
        return self._lost

    def _lose(self, reason: str) -> None:
        """Report that the other end, or the camera behind it, is lost; once for each reason."""
        if reason != self._lost:
            self._lost = reason
            # A warning, as for a local camera: a command's log shows the loss nowhere else.
            log.warning("%s: %s", self.info.uri, reason)
            self.connection_changed.emit(ConnectionState.LOST, reason)

    def _report_return(self) -> None:
        """Report that the server and its camera are available again."""
        self._lost, how = "", return_text(self.unlike_before, self.changed_meanwhile)
        log.warning("%s: back, %s", self.info.uri, how)
        self.connection_changed.emit(ConnectionState.OPEN, how)

    def _ask_for_loss(self) -> str:
        """Return why the camera behind a server of ours is lost; empty if it is not, or unknown."""
        features = self._connected()
        if not isinstance(features, TreeFeatures):
            return ""
        features.look()
        return features.lost

    def _report_camera(self, features: RemoteFeatures) -> None:
        """Report the loss or return of the camera behind a server of ours; call it after reading the changes.

        The server has restored all settings by then, so it reports which of them differ now.
        """
        if not isinstance(features, TreeFeatures):
            return
        if self._lost and not features.lost:
            with self._lock:
                features.look()
            self.unlike_before = features.unlike_before
            self.changed_meanwhile = features.changed_meanwhile
        if features.lost:
            self._lose(features.lost)
        elif self._lost:
            self._report_return()

    def _recognise(self, info: DeviceInfo) -> None:
        """Store the other end's description of its camera. Raises OtherCameraError for another unit.

        Only our own servers name the unit that they serve; others are accepted again without this check.
        """
        if self.info.vendor and not (info.vendor or info.model):
            return  # a server that has not opened its camera yet
        if self.info.vendor:
            require_same(self.info, info)
        self.info = info

    @override
    def feature_tree(self) -> Category:
        return self._known().tree

    @override
    def has_feature(self, name: str) -> bool:
        return self._known().has(name)

    @override
    def feature(self, name: str) -> Feature:
        self._require(name)
        with self._lock:
            return self._note(self._shown(name), self._connected().read(name))

    @property
    @override
    def reads_at_once(self) -> int:
        return READS_AT_ONCE if isinstance(self._known(), TreeFeatures) else 1

    @override
    def read_features(self, names: Sequence[str]) -> list[Feature]:
        if not isinstance(self._known(), TreeFeatures):
            return super().read_features(names)
        for name in names:
            self._require(name)
        with self._lock:
            shown = [self._shown(name) for name in names]
            tree = self._connected()
            assert isinstance(tree, TreeFeatures)
            return [self._note(*one) for one in zip(shown, tree.read_several(names), strict=True)]

    @override
    def write_feature(self, name: str, value: FeatureValue) -> Feature:
        self._require_control(name)
        with self._lock:
            return self._note(self._shown(name), self._connected().write(name, value))

    @override
    def execute(self, name: str) -> None:
        self._require_control(name)
        with self._lock:
            self._connected().execute(name)

    @override
    def read_setting(self, key: SettingKey) -> Feature:
        self._require(key.name)
        with self._lock:
            tree = self._selecting_tree()
            return super().read_setting(key) if tree is None else self._note(key, tree.read(str(key)))

    @override
    def write_setting(self, key: SettingKey, value: FeatureValue) -> WriteResult:
        self._require_control(key.name)
        with self._lock:
            tree = self._selecting_tree()
            if tree is None:
                return super().write_setting(key, value)
            result = tree.write_setting(key, value)
            for change in (*result.consequences, *result.written):
                if change.after is not None:
                    self._remember(change.key, change.after)
            return result

    @override
    def execute_setting(self, key: SettingKey) -> None:
        self._require_control(key.name)
        with self._lock:
            tree = self._selecting_tree()
            if tree is None:
                super().execute_setting(key)
            else:
                tree.execute(str(key))

    @override
    @contextmanager
    def exclusive(self, selectors: Iterable[str] = ()) -> Iterator[None]:
        """Keep other threads out. Each request keeps out the other clients of the server."""
        with self._lock, super().exclusive(() if self._selecting_tree() else selectors):
            yield

    def _selecting_tree(self) -> TreeFeatures | None:
        """Return the features of a server that selects by itself; None for any other."""
        features = self._connected()
        return features if isinstance(features, TreeFeatures) and features.selects else None

    def _require_control(self, name: str) -> None:
        self._require(name)
        if self.access is Access.MONITOR:
            raise FeatureAccessError(f"{name}: {self.info.title} was opened for reading only", name)

    def _shown(self, name: str) -> SettingKey | None:
        """Return the setting that a feature shows; None if its selectors have not been read."""
        path = [SettingKey(selector) for selector in self.selectors.of(name)]
        if not all(key in self._seen for key in path):
            return None
        return SettingKey(name, tuple((key.name, format_value(self._seen[key])) for key in path))

    def _note(self, key: SettingKey | None, feature: Feature) -> Feature:
        if key is not None and feature.value is not None and feature.access.writable:
            self._remember(key, feature.value)
        return feature

    def _remember(self, key: SettingKey, value: FeatureValue) -> None:
        self._seen.pop(key, None)
        if len(self._seen) >= MOST_SEEN:
            self._seen.pop(next(iter(self._seen)))
        self._seen[key] = value

    def _forget_seen(self, names: frozenset[str]) -> None:
        """Forget the last known values of features that others changed."""
        for key in [key for key in self._seen if key.name in names]:
            del self._seen[key]

    def _compare_with_seen(self) -> None:
        """Set `unlike_before` once the other end is back. The caller holds the lock."""
        unlike = []
        for key, before in list(self._seen.items()):
            if not self.has_feature(key.name):
                unlike.append(f"{key} is not there any more")
                continue
            try:
                feature = self.read_setting(key)
                mode = Companions.of(key.name, self.has_feature).mode
                if feature.value is None or (mode is not None and regulating(self.feature(mode))):
                    continue
            except FeatureError as error:
                unlike.append(str(error))
                continue
            if not same_value(feature.value, before):
                unlike.append(f"{key} is {format_value(feature.value)} instead of {format_value(before)}")
        self.unlike_before, self.changed_meanwhile = tuple(unlike), ()

    def stop(self) -> None:
        """Stop receiving frames. The remote camera itself continues."""
        with self._stream_lock:
            stream, self._stream = self._stream, None
            if stream is not None:
                stream.close()
                self._statistics = stream.statistics()

    @override
    @property
    def streaming(self) -> bool:
        return self._stream is not None

    @override
    def silence(self) -> str:
        stream = self._stream
        return stream.silence() if stream is not None else ""

    @override
    def statistics(self) -> StreamStatistics:
        stream = self._stream
        return stream.statistics() if stream is not None else self._statistics

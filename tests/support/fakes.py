"""Grabbers and devices that a test controls."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable
from dataclasses import replace

from grabbergui.core.errors import FeatureAccessError, GrabberError
from grabbergui.core.features import Category, Feature, FeatureKind, FeatureValue
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.identity import DeviceInfo
from grabbergui.driver.device import Device, StreamRequest
from patience import PATIENCE


def categories(features: Iterable[Feature]) -> Category:
    """Return the tree that the features' `category` fields describe, one level deep."""
    branches: dict[str, list[Feature]] = {}
    for feature in features:
        branches.setdefault(feature.category or "Features", []).append(feature)
    return Category("Root", members=tuple(Category(name, members=tuple(m)) for name, m in branches.items()))


class ScriptedGrabber(FrameGrabber):
    """A grabber made of a list of features, with delays and failures; records the calls.

    Writes obey `Feature.validated`, then `on_write` may return what the camera makes of the value.
    """

    def __init__(self, features: Iterable[Feature] = (), tree: Category | None = None) -> None:
        super().__init__(DeviceInfo("scripted:", vendor="Acme", model="Script"))
        known = list(features)
        self.known: dict[str, Feature] = {feature.name: feature for feature in known}
        self.tree = tree or categories(known)
        self.reads: list[str] = []
        self.writes: list[tuple[str, FeatureValue, float]] = []
        "Name, value as given, `time.monotonic`."
        self.commands: list[str] = []
        self.threads: set[str] = set()
        "Names of the threads that called."
        self.delays: dict[str, float] = {}
        "Seconds that a call about this feature takes."
        self.failures: dict[str, Exception] = {}
        "What a call about this feature raises."
        self.refusals: dict[str, Exception] = {}
        "What writing this feature raises."
        self.on_write: Callable[[str, FeatureValue], FeatureValue] = lambda name, value: value
        self.gate = threading.Event()
        "Cleared, every feature call waits for it (at most five seconds)."
        self.gate.set()
        self._streaming = False
        self._access = Access.CONTROL

    def set(self, name: str, value: FeatureValue | None = None, **changes: object) -> None:
        """Change a feature as if the camera did it, and report it."""
        if value is not None:
            changes["value"] = value
        self.known[name] = replace(self.known[name], **changes)  # type: ignore[arg-type]
        self.features_changed.emit(frozenset([name]))

    def send(self, frame: Frame) -> None:
        """Deliver a frame to all consumers."""
        self._fanout.put(frame)

    def open(self, access: Access = Access.CONTROL) -> None:
        self._access = Access.MONITOR if access is Access.MONITOR else Access.CONTROL

    def close(self) -> None:
        self._streaming = False

    @property
    def access(self) -> Access:
        return self._access

    def feature_tree(self) -> Category:
        return self.tree

    def has_feature(self, name: str) -> bool:
        return name in self.known

    def feature(self, name: str) -> Feature:
        self._enter(name)
        self.reads.append(name)
        return self.known[name]

    def write_feature(self, name: str, value: FeatureValue) -> Feature:
        self.writes.append((name, value, time.monotonic()))
        self._enter(name)
        if name in self.refusals:
            raise self.refusals[name]
        accepted = self.on_write(name, self.known[name].validated(value))
        self.known[name] = replace(self.known[name], value=accepted)
        return self.known[name]

    def execute(self, name: str) -> None:
        self._enter(name)
        if self.known[name].kind is not FeatureKind.COMMAND:
            raise FeatureAccessError(f"{name} is no command", name)
        self.commands.append(name)

    def start(self, *, keep_trigger: bool = False) -> None:
        self._streaming = True

    def stop(self) -> None:
        self._streaming = False

    @property
    def streaming(self) -> bool:
        return self._streaming

    def statistics(self) -> StreamStatistics:
        return StreamStatistics()

    def _enter(self, name: str) -> None:
        self.threads.add(threading.current_thread().name)
        self.gate.wait(PATIENCE)
        self._require(name)
        if name in self.delays:
            time.sleep(self.delays[name])
        if name in self.failures:
            raise self.failures[name]


class XmlDevice(Device):
    """A device that consists of a description and a register memory full of zeros."""

    def __init__(self, xml: bytes) -> None:
        super().__init__(DeviceInfo("xml:", vendor="Acme", model="Register file", bus="Memory"))
        self.xml = xml
        self.memory: dict[int, int] = {}
        "Byte address to byte; what is missing is zero."
        self.writes: list[tuple[int, bytes]] = []

    def open(self, access: Access) -> Access:
        return access

    def close(self) -> None:
        pass

    def read(self, address: int, length: int) -> bytes:
        return bytes(self.memory.get(address + offset, 0) for offset in range(length))

    def write(self, address: int, data: bytes) -> None:
        self.writes.append((address, data))
        self.memory.update({address + offset: byte for offset, byte in enumerate(data)})

    def description(self) -> bytes:
        return self.xml

    def open_stream(self, request: StreamRequest, deliver: Callable[[Frame], None]) -> None:
        raise GrabberError("a register file has no stream")

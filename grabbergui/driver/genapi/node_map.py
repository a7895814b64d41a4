"""A camera's node map, protected by one lock."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from typing import Any

from genicam import genapi

from grabbergui.core.errors import (
    DeviceLostError,
    FeatureAccessError,
    FeatureError,
    FeatureNotFoundError,
    FeatureValueError,
    GrabberError,
    RemoteProtocolError,
    TransportError,
)
from grabbergui.core.features import (
    AccessCondition,
    Category,
    Feature,
    FeatureKind,
    FeatureValue,
    format_value,
)
from grabbergui.core.grabber import DeviceEvent
from grabbergui.core.sfnc import automatic_mode_of
from grabbergui.driver.device import Device
from grabbergui.driver.genapi import node_features
from grabbergui.driver.genapi.cleaning import clean_xml, port_name
from grabbergui.driver.genapi.conditions import Conditions
from grabbergui.driver.genapi.event_reader import EventReader
from grabbergui.driver.genapi.feature_tree import FeatureTree
from grabbergui.driver.genapi.loading import load
from grabbergui.driver.genapi.map_lock import MapLock
from grabbergui.driver.genapi.node_callbacks import register_callback
from grabbergui.driver.genapi.node_features import NodeFeature
from grabbergui.driver.genapi.port import RegisterPort
from grabbergui.driver.genapi.register_length import require_length

log = logging.getLogger(__name__)

COMMAND_TIMEOUT = 5.0
"""Seconds until a command must be done."""
ACTS_AT_ONCE = frozenset({"AcquisitionStart", "AcquisitionStop", "AcquisitionAbort", "TriggerSoftware"})
"""Commands that have acted even if the camera never says so: the register of many keeps its value."""
ACTION_TIME = 1.0
"""Seconds to wait for one of these, once; a camera that reports the end may need a frame for it."""

_GENAPI_ERRORS = (genapi.GenericException, RuntimeError, OverflowError, TypeError, ValueError)
"""Exceptions of C++, of our port, and of SWIG for a value that it cannot convert."""


class CameraNodeMap:
    """The features of one open device. Any thread; calls are serialised.

    GenApi locks its map in C++ while it calls our port, and the binding keeps the GIL: two threads inside
    would deadlock. So each use holds `_lock`, a Python lock.

    `on_change` is called with the names of features whose value, range or access may have changed, outside
    the lock, on the thread whose call caused it.
    """

    def __init__(self, device: Device, xml: bytes, on_change: Callable[[frozenset[str]], None]) -> None:
        self._lock = MapLock(on_change)
        self._port = RegisterPort(device)
        text = clean_xml(xml)
        device.use_description(text)
        try:
            self._map = load(text)
            with self._lock:
                self._map.connect(self._port, port_name(text))
        except (genapi.GenericException, RuntimeError) as error:
            raise RemoteProtocolError(
                f"the camera's description cannot be used: {node_features.reason_of(error)}"
            ) from error
        self._callbacks: list[tuple[Any, int]] = []
        self._nodes: dict[str, NodeFeature] = {}
        "Features used so far."
        self._keep_their_value: set[str] = set()
        "Commands of ACTS_AT_ONCE whose end this camera does not report."
        self._dependents: dict[str, frozenset[str]] = {}
        self._events: EventReader | None = None
        try:
            with self._lock:
                # First, because GenApi treats an event's nodes as implemented only with an adapter.
                if device.event_layout:
                    self._events = EventReader(self._map, device.event_layout)
                tree = FeatureTree(self._map)
                self._port.take_failure()  # the features that failed say so themselves
                self._root, self._descriptions = tree.root, tree.descriptions
                self._conditions = Conditions(self._map, self._descriptions)
                self._listen()
        except BaseException:
            self.close()  # a map that is collected with its event adapter or callbacks ends the process
            raise

    @property
    def root(self) -> Category:
        """The feature tree."""
        return self._root

    def has(self, name: str) -> bool:
        """Whether the camera implements a feature of this name."""
        return name in self._descriptions

    def has_node(self, name: str) -> bool:
        """Whether the description has a node of this name, a feature or not."""
        with self._lock:
            return bool(self._map.has_node(name))

    def entry_numbers(self, name: str) -> dict[int, str]:
        """Return the entries of an enumeration by number, available or not; empty for any other node."""
        with self._lock:
            node = self._map.get_node(name) if self._map.has_node(name) else None
            if not isinstance(node, genapi.IEnumeration):
                return {}
            return {int(entry.value): str(entry.symbolic) for entry in node.entries}

    def feature(self, name: str) -> Feature:
        """Return a snapshot of a feature (see `has`), or of a node outside the feature tree."""
        with self._lock:
            feature = self._node(name).snapshot()
            self._raise_loss()
        return feature

    def conditions(self, name: str) -> tuple[AccessCondition, ...]:
        """Return what hides or locks a feature; empty if the description does not say."""
        with self._lock:
            access = node_features.access_of(self._map.get_node(name))
            conditions = self._conditions.of(name, access)
            self._raise_loss()
        return conditions

    def explained(self, name: str) -> Feature:
        """Return a snapshot of a feature with what hides or locks it."""
        feature = self.feature(name)
        return feature if feature.access.writable else replace(feature, conditions=self.conditions(name))

    def taking(self, name: str, value: FeatureValue) -> tuple[Feature, FeatureValue] | None:
        """Return the last snapshot of a number that takes this value, and the value as its own type.

        None where a new one is needed. Before a write it is not: GenApi checks access and range again, and
        its refusal is described by the state at that moment. This saves a dragged slider half of its time.
        """
        last = self._nodes[name].last if name in self._nodes else None
        if last is not None and last.kind in (FeatureKind.INTEGER, FeatureKind.FLOAT):
            try:
                return last, last.validated(value)
            except FeatureError:
                return None
        return None

    def value(self, name: str) -> FeatureValue | None:
        """Return the value alone, much faster than `feature`; None if it cannot be read."""
        with self._lock:
            value = self._node(name).value()
            self._raise_loss()
        return value

    def write(self, name: str, value: FeatureValue) -> None:
        """Write a validated value. Raises FeatureError and what the device raised."""
        with self._lock:
            self._assign(name, value)

    def write_and_read(self, name: str, value: FeatureValue) -> Feature:
        """Write as `write`, and return the feature as it is then, in one step."""
        with self._lock:
            feature = self._assign(name, value).snapshot()
            self._raise_loss()
        return feature

    def dependents(self, name: str) -> frozenset[str]:
        """Return the features that a write of `name` may change, by the description's invalidation rules.

        These are all nodes that depend on the feature or on one of its registers. Needs no camera access.
        """
        if name not in self._dependents:
            with self._lock:
                node = self._map.get_node(name).node
                registers = node._get_children(genapi.ELinkType.ctTerminalNodes)
                depending = {
                    dependent.node.name
                    for start in (node, *(register.node for register in registers))
                    for dependent in start._get_children(genapi.ELinkType.ctDependingNodes)
                }
            self._dependents[name] = frozenset(depending & self._descriptions.keys()) - {name}
        return self._dependents[name]

    def is_locked_by(self, name: str, lock: str) -> bool:
        """Whether a feature would be writable if the integer or boolean node `lock` were 0.

        Sets the node to 0 for a moment and asks GenApi for the feature's access.
        """
        if name not in self.dependents(lock):
            return False
        with self.unreported():
            switch = self._map.get_node(lock)
            locked = switch.value
            try:
                if node_features.access_of(self._map.get_node(name)).writable or not locked:
                    return False
                switch.set_value(type(locked)(0))
                try:
                    return node_features.access_of(self._map.get_node(name)).writable
                finally:
                    switch.set_value(locked)
            except (genapi.GenericException, RuntimeError) as error:
                log.info("whether %s locks %s: %s", lock, name, node_features.reason_of(error))
                return False
            finally:
                self._port.take_failure()

    def values(self, names: Sequence[str]) -> dict[str, FeatureValue]:
        """Return the values of the features that are currently readable."""
        if not names:
            return {}
        with self._lock:
            found = {name: value for name in names if (value := self._node(name).value()) is not None}
            self._raise_loss()
        return found

    def cached_values(self) -> dict[str, FeatureValue]:
        """Return the values in GenApi's cache, without access to the camera, which may be lost."""
        found: dict[str, FeatureValue] = {}
        with self._lock:
            for name in self._descriptions:
                if self._map.get_node(name).is_value_cache_valid():
                    value = self._node(name).value()
                    if value is not None:
                        found[name] = value
            self._port.take_failure()  # a feature's access mode may need a register after all
        return found

    def exclusive(self) -> AbstractContextManager[None]:
        """Block all other threads for the block; report changes after it."""
        return self._lock

    @contextmanager
    def unreported(self) -> Iterator[None]:
        """Suppress reports from a block that restores every feature it changes; other threads wait."""
        with self._lock:
            changed = set(self._lock.changed)
            try:
                yield
            finally:
                self._lock.changed.intersection_update(changed)  # the callbacks hold this very set

    def execute(self, name: str, *, wait: bool = True) -> None:
        """Run a command, and wait until it is done. Raises FeatureError and what the device raised.

        One of ACTS_AT_ONCE is taken as done after ACTION_TIME, and from then on at once.
        """
        with self._lock, self._answering(name):
            if not self._map.has_node(name):
                raise FeatureNotFoundError(f"the camera's description has no command {name}", name)
            command = self._map.get_node(name)
            if not isinstance(command, genapi.ICommand):
                raise FeatureAccessError(f"{name} is no command; it can be written instead", name)
            access = node_features.access_of(command)
            if not access.writable:
                raise FeatureAccessError(f"{name} {self.explained(name).access_problem()}", name)
            command.execute()
        if not wait:
            return
        # Release the lock between the checks, so that a slow command does not block other threads.
        if name in self._keep_their_value:
            return
        at_once = name in ACTS_AT_ONCE
        deadline = time.monotonic() + (ACTION_TIME if at_once else COMMAND_TIMEOUT)
        while not self._is_done(name):
            if time.monotonic() > deadline:
                if at_once:
                    self._keep_their_value.add(name)
                    log.info("the camera does not report that %s is done; it is no longer waited for", name)
                    return
                raise FeatureError(f"{name} was not done within {COMMAND_TIMEOUT:g} s", name)
            time.sleep(0.005)

    def register_length(self, name: str) -> int:
        """Return the size in bytes of a register node. Raises FeatureAccessError for any other node."""
        with self._lock, self._answering(name):
            return self._length(name)

    def read_register(self, name: str, length: int) -> bytes:
        """Return the first `length` bytes of a register, bypassing GenApi's cache."""
        with self._lock, self._answering(name):
            self._length(name)
            return bytes(self._register(name).get(length, False, True)) if length else b""

    def write_register(self, name: str, content: bytes) -> None:
        """Write bytes to the beginning of a register."""
        with self._lock, self._answering(name):
            self._length(name)
            self._register(name).set(content)

    def invalidate(self, names: frozenset[str]) -> None:
        """Drop cached values, so that the next snapshot reads them from the camera."""
        with self._lock:
            for name in names:
                node = self._map.get_node(name).node
                # The registers that hold the value have caches of their own.
                for register in node._get_children(genapi.ELinkType.ctTerminalNodes):
                    register.node.invalidate_node()
                node.invalidate_node()
            self._lock.changed.update(names)

    def poll(self, elapsed_ms: int) -> None:
        """Let GenApi drop cached values whose PollingTime has passed. Reads no registers."""
        with self._lock:
            self._map.poll(elapsed_ms)

    def take_event(self, event_id: int, message: bytes) -> DeviceEvent | None:
        """Update the event's nodes from a message and return the event; None without event support.

        Raises RemoteProtocolError for a message that GenApi cannot read.
        """
        with self._lock:
            if self._events is None:
                return None
            self._events.deliver(message)
            # Read the event's own nodes only; others that it invalidated are read on demand.
            changed = sorted(name for name in self._lock.changed if name.startswith("Event"))
            return self._events.event(event_id, {name: self.feature(name) for name in changed})

    def close(self) -> None:
        """Deregister the callbacks. The map must not be used afterwards."""
        with self._lock:
            events, self._events = self._events, None
            if events is not None:
                events.close()
            self._lock.on_change = lambda names: None
            for node, handle in self._callbacks:
                node.deregister_callback(handle)
            self._callbacks.clear()
            self._nodes.clear()

    def _node(self, name: str) -> NodeFeature:
        """Return a node as a feature. Raises FeatureAccessError if it has no value."""
        node = self._nodes.get(name)
        if node is None:
            value = self._map.get_node(name)
            description = self._descriptions.get(name) or node_features.describe(value.node, "")
            if description is None:
                raise FeatureAccessError(f"{name} is a register without a value of its own", name)
            node = self._nodes[name] = NodeFeature(value, description, automatic_mode_of(name, self.has))
        return node

    def _register(self, name: str) -> Any:
        register = self._map.get_node(name) if self._map.has_node(name) else None
        if not isinstance(register, genapi.IRegister):
            raise FeatureAccessError(f"the camera's description has no register {name}", name)
        return register

    def _length(self, name: str) -> int:
        length = int(self._register(name).length)
        require_length(length, name)
        return length

    def _assign(self, name: str, value: FeatureValue) -> NodeFeature:
        node = self._node(name)
        self._port.take_failure()
        try:
            node.assign(value)
        except RemoteProtocolError as error:
            raise FeatureError(f"{name}: {error}", name) from error
        except GrabberError:  # some are a ValueError, too
            raise
        except _GENAPI_ERRORS as error:
            raise self._answer(error, name, value) from error
        return node

    def _raise_loss(self) -> None:
        failure = self._port.take_failure()
        if isinstance(failure, DeviceLostError):
            raise failure

    @contextmanager
    def _answering(self, name: str) -> Iterator[None]:
        """Turn GenApi's exceptions into ours, and into the device's own where it caused them."""
        self._port.take_failure()
        try:
            yield
        except GrabberError:  # some are a ValueError, too
            raise
        except _GENAPI_ERRORS as error:
            raise self._answer(error, name) from error

    def _answer(self, error: Exception, name: str, value: FeatureValue | None = None) -> GrabberError:
        """Return our error for an exception of GenApi: the device's own error, or a refused request."""
        what = name if value is None else f"{name}={format_value(value)}"
        if isinstance(error, (OverflowError, TypeError, ValueError)):
            return FeatureValueError(f"{what}: {error}", name)
        failure = self._port.take_failure()
        if isinstance(failure, TransportError):
            return failure
        answer = str(failure) if failure else node_features.reason_of(error)
        message = f"{what}: the camera answered: {answer}"
        if isinstance(error, genapi.OutOfRangeException):
            return FeatureValueError(f"{message} (allowed: {self.feature(name).range_text()})", name)
        if isinstance(error, genapi.AccessException) and failure is None:
            return FeatureAccessError(f"{what}: {self.explained(name).access_problem()}", name)
        return FeatureError(message, name)

    def _is_done(self, name: str) -> bool:
        with self._lock:
            try:
                return bool(self._map.get_node(name).is_done())
            except (genapi.GenericException, RuntimeError) as error:
                failure = self._port.take_failure()
                if isinstance(failure, GrabberError) and not isinstance(failure, TransportError):
                    raise FeatureError(f"{name}: the camera answered: {failure}", name) from error
                # After commands like DeviceReset the device cannot report that it is done.
                return True

    def _listen(self) -> None:
        for name in self._descriptions:
            node = self._map.get_node(name).node
            self._callbacks.append((node, register_callback(node, self._lock.changed.add)))

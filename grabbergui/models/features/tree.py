"""The features of an open source as the window sees them: last known values, requests, writes."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Iterable, Set
from dataclasses import fields, replace
from functools import partial
from itertools import islice
from typing import TypeVar

from psygnal import Signal

from grabbergui.core.errors import DeviceLostError, GrabberError, TransportError
from grabbergui.core.features import (
    AccessCondition,
    AccessMode,
    Category,
    Feature,
    FeatureDescription,
    FeatureKind,
    FeatureValue,
    format_value,
)
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.settings import SettingKey
from grabbergui.core.sfnc import FAVOURITES
from grabbergui.models.features.worker import FeatureWorker
from grabbergui.models.features.write_throttle import WriteThrottle

log = logging.getLogger(__name__)

T = TypeVar("T")

READ_TURN = 0.01
"""Longest run of reads in seconds; a waiting job, such as a write, interrupts it after one feature."""


class FeatureTreeModel:
    """A grabber's features for views that show and edit them.

    Create it when the grabber is open, on the worker or before the worker has other jobs. All methods may be
    called from any thread and none waits for the camera; signals are emitted from any thread. When the camera
    reports changes, only watched features are read again, so the cost of a panel with thousands of features
    depends on its open part.
    """

    feature_changed = Signal(Feature)
    """A feature as it is now: it changed, was requested, or was written."""
    structure_changed = Signal()
    """`root` and `favourites` were replaced; earlier features are invalid."""
    failed = Signal(GrabberError)
    """A write, command or read failed."""

    def __init__(
        self,
        grabber: FrameGrabber,
        worker: FeatureWorker,
        witness: Callable[[Feature], None] = lambda feature: None,
    ) -> None:
        """`witness` is called on the worker with everything that is read."""
        self._grabber = grabber
        self._worker = worker
        self._witness = witness
        self._lock = threading.RLock()
        self._closed = False
        self._features: dict[str, Feature] = {}
        self._wanted: dict[str, bool] = {}
        "Features still to be read, oldest first; whether to publish each even if it did not change."
        self._reading = False
        "Whether a reading job is in progress."
        self._one_by_one = 0
        "Number of features to read one by one, after a joint read failed."
        self._watched: frozenset[str] = frozenset()
        self._companions: frozenset[str] = frozenset()
        "Automatic modes of the watched features."
        self._stale: set[str] = set()
        "Features that changed while they were not watched."
        self._held: set[str] = set()
        self._deferred: set[str] = set()
        "Features that changed while held."
        self._throttle = WriteThrottle()
        self._values: dict[str, FeatureValue] = {}
        "Values of requested writes that are not confirmed yet."
        self._writing: int | None = None
        "The thread of the write in progress: the write itself returns most of its consequences."
        self._changed_by_write: set[str] = set()
        "Changes that the grabber reported on this thread since the write began."
        self._load()
        grabber.features_changed.connect(self._on_grabber_features_changed)

    def _load(self) -> None:
        self.root: Category = self._grabber.feature_tree()
        self._selectors = self._grabber.selectors
        self._descriptions = self._selectors.descriptions
        found = (self._grabber.role(role) for role in FAVOURITES)
        self.favourites: tuple[str, ...] = tuple(name for name in found if name is not None)

    def reload(self) -> None:
        """Ask the grabber for its tree again, as after a loss; `structure_changed` follows if it differs."""
        self._worker.submit(self._load_anew, key="reload features", failed=self._fail)

    def close(self) -> None:
        """Stop listening and emitting. Waiting writes are sent before any later job."""
        self._grabber.features_changed.disconnect(self._on_grabber_features_changed, missing_ok=True)
        with self._lock:
            self._closed = True
            self._wanted.clear()
            for name in self._throttle.waiting():
                self._submit_write(name, self._values[name], 0.0)

    @property
    def known(self) -> tuple[Feature, ...]:
        """Every feature read so far, in its last known state."""
        with self._lock:
            return tuple(self._features.values())

    def feature(self, name: str) -> Feature | None:
        """Return a feature's last known state without asking the camera; None if it was never read."""
        return self._features.get(name)

    def description(self, name: str) -> FeatureDescription | None:
        """Return the constant properties of a feature; None if the camera does not have it."""
        return self._descriptions.get(name)

    def request(self, names: Iterable[str]) -> None:
        """Read these features; `feature_changed` follows for each, whether it changed or not."""
        self._want(names, always=True)

    def explain(self, name: str) -> None:
        """Find out what hides or locks a feature; `feature_changed` follows with its conditions, if any."""
        self._worker.submit(
            lambda: self._grabber.conditions(name),
            key=f"explain {name}",
            done=partial(self._on_explained, name),
            failed=lambda error: log.info("what hides or locks %s: %s", name, error),
        )

    def watch(self, names: Iterable[str]) -> None:
        """Follow only these features and their automatic modes from now on.

        Reads those that are not known yet or have changed since they were last watched.
        """
        with self._lock:
            self._watched = frozenset(names) & self._descriptions.keys()
            autos = (feature.auto for name in self._watched if (feature := self._features.get(name)))
            self._companions = frozenset(auto for auto in autos if auto)
            # In the tree's order, so that a panel fills from the top.
            followed = [name for name in self._descriptions if self._follows(name)]
            dropped = [
                name for name, always in self._wanted.items() if not always and not self._follows(name)
            ]
            for name in dropped:
                del self._wanted[name]
                self._stale.add(name)
            self._want(
                (name for name in followed if name not in self._features or name in self._stale), always=False
            )

    def write(self, name: str, value: FeatureValue) -> None:
        """Write as soon as possible, each feature at most 60 times a second, in the order of the requests.

        A newer value replaces a waiting one, so the last value is always written. The write goes to the
        instance that is shown, even if others select another one in the meantime. The resulting value
        follows as `feature_changed`. A refusal is reported by `failed`, and the feature is read again, so
        that views show its true value.
        """
        with self._lock:
            if self._closed:
                return
            delay = self._throttle.ask(name, time.monotonic())
            self._values[name] = value
            self._submit_write(name, value, delay)

    def execute(self, name: str) -> None:
        """Run a command after all writes requested before."""
        key = self._shown_setting(name)
        self.run(partial(self._grabber.execute_setting, key), done=lambda _: self.request([name]))

    def run(
        self,
        job: Callable[[], T],
        done: Callable[[T], None] | None = None,
        failed: Callable[[GrabberError], None] | None = None,
    ) -> bool:
        """Run a job on the worker after all writes requested before; then `done` or `failed`, there too.

        Without `failed`, the signal of that name is emitted. Returns False and does nothing once closed.
        """
        with self._lock:
            if self._closed:
                return False
            delay = self._throttle.barrier(time.monotonic())
            return self._worker.submit(job, done=done, failed=failed or self._fail, delay=delay)

    def hold(self, name: str) -> None:
        """Hold back changes of a feature until `release`: the user drags its control or types into it."""
        with self._lock:
            self._held.add(name)

    def release(self, name: str) -> None:
        """End the hold, and emit a change that it held back."""
        with self._lock:
            self._held.discard(name)
            if name not in self._deferred or self._throttle.waits(name):
                return
            self._deferred.discard(name)
            feature = self._features[name]
        self.feature_changed.emit(feature)

    def _load_anew(self) -> None:
        if self._grabber.feature_tree() == self.root:
            return
        self._load()
        with self._lock:
            self._features.clear()
            self._deferred.clear()
            self._wanted.clear()
            self._stale.clear()
            self._watched = self._companions = frozenset()
        self.structure_changed.emit()

    def _submit_write(self, name: str, value: FeatureValue, delay: float) -> None:
        self._worker.submit(
            partial(self._send, self._shown_setting(name), value),
            key=f"write {name}",
            done=self._publish_all,
            failed=partial(self._on_write_refused, name),
            delay=delay,
        )

    def _shown_setting(self, name: str) -> SettingKey:
        """Return the instance that is shown: its selectors as requested last, or else as last known."""
        with self._lock:
            selected = []
            for selector in self._selectors.of(name):
                known = self._features.get(selector)
                value = self._values.get(selector, known.value if known is not None else None)
                if value is None:
                    return SettingKey(name)
                selected.append((selector, format_value(value)))
            return SettingKey(name, tuple(selected))

    def _send(self, key: SettingKey, value: FeatureValue) -> list[Feature]:
        """Write, and return the features that need no further read, the written one first.

        On a remote camera a read is a request and costs as much as the write.
        """
        with self._lock:
            self._throttle.sent(key.name, time.monotonic())
        if not key.selected:
            self._writing = threading.get_ident()
        returned: list[Feature] = []
        try:
            result = self._grabber.write_setting(key, value)
            changes = {change.key.name: change.key for change in (*result.written, *result.consequences)}
            # With selectors, the change may be of an instance that is not shown.
            shown = [f for f in result.also_changed if changes.get(f.name) == self._shown_setting(f.name)]
            returned = [result.feature, *shown]
        finally:
            self._writing = None
            changed, self._changed_by_write = self._changed_by_write, set()
            self._want_changed(changed.difference(feature.name for feature in returned))
        return returned

    def _publish_all(self, written: list[Feature]) -> None:
        for feature in written:
            self._publish(self._grabber.offered(feature), always=feature is written[0])

    def _on_explained(self, name: str, conditions: tuple[AccessCondition, ...]) -> None:
        known = self._features.get(name)
        if known is not None and conditions:
            self._publish(replace(known, conditions=conditions), always=False)

    def _on_write_refused(self, name: str, error: GrabberError) -> None:
        with self._lock:
            self._forget_requested(name)
        self._fail(error)
        self._want([name], always=True)

    def _want(self, names: Iterable[str], always: bool) -> None:
        with self._lock:
            if self._closed:
                return
            for name in names:
                self._wanted[name] = always or self._wanted.get(name, False)
            if self._wanted and not self._reading:
                self._reading = self._worker.submit(self._read_some)

    def _read_some(self) -> None:
        deadline = time.monotonic() + READ_TURN
        while True:
            with self._lock:
                if not self._wanted:
                    break
                names = list(islice(self._wanted, self._reads_at_once()))
                wanted = {name: self._wanted.pop(name) for name in names}
            if len(names) > 1:
                self._read_together(wanted)
            else:
                self._read(names[0], wanted[names[0]])
            if time.monotonic() >= deadline or self._worker.has_due_job:
                break
        with self._lock:
            self._reading = bool(self._wanted) and self._worker.submit(self._read_some)

    def _reads_at_once(self) -> int:
        if self._one_by_one:
            self._one_by_one -= 1
            return 1
        try:
            return self._grabber.reads_at_once
        except GrabberError:  # the grabber was closed
            return 1

    def _read_together(self, wanted: dict[str, bool]) -> None:
        """Read several features by one request. If any of them fails, read them one by one next."""
        try:
            features = self._grabber.read_features(list(wanted))
        except Exception as error:
            log.debug("%s are read one by one: %s", ", ".join(wanted), error)
            with self._lock:
                if not self._closed:
                    again = {name: always or self._wanted.pop(name, False) for name, always in wanted.items()}
                    self._wanted = again | self._wanted
                    self._one_by_one = len(wanted)
            return
        for (name, always), feature in zip(wanted.items(), features, strict=True):
            self._read(name, always, feature)

    def _read(self, name: str, always: bool, feature: Feature | None = None) -> None:
        """Publish a feature; read it first unless it is passed."""
        try:
            feature = feature or self._grabber.feature(name)
            self._publish(self._grabber.offered(feature), always)
            self._witness(feature)
        except TransportError as error:
            if isinstance(error, DeviceLostError):
                with self._lock:
                    self._wanted.clear()
            self._fail(error)
            self._publish(self._features.get(name) or self._broken(name, str(error)), always)
        except GrabberError as error:
            self._publish(self._broken(name, str(error)), always)
        except Exception as error:
            # One odd node must not affect the others.
            log.exception("%s could not be read", name)
            self._publish(self._broken(name, f"{type(error).__name__}: {error}"), always)

    def _broken(self, name: str, problem: str) -> Feature:
        known = self._descriptions.get(name) or FeatureDescription(name=name, kind=FeatureKind.STRING)
        described = {field.name: getattr(known, field.name) for field in fields(FeatureDescription)}
        return Feature(**described, access=AccessMode.NOT_AVAILABLE, problem=problem)

    def _publish(self, feature: Feature, always: bool) -> None:
        name = feature.name
        with self._lock:
            changed = self._features.get(name) != feature
            self._features[name] = feature
            self._forget_requested(name)
            self._stale.discard(name)
            if self._closed or not (changed or always):
                return
            if feature.auto and name in self._watched and not self._follows(feature.auto):
                self._companions |= {feature.auto}
                self._want([feature.auto], always=True)
            if name in self._held:
                self._deferred.add(name)
                return
            # A newer value waits to be written; showing this one would make the control jump.
            if self._throttle.waits(name):
                return
            self._deferred.discard(name)
        self.feature_changed.emit(feature)

    def _forget_requested(self, name: str) -> None:
        if not self._throttle.waits(name):
            self._values.pop(name, None)

    def _fail(self, error: GrabberError) -> None:
        if not self._closed:
            self.failed.emit(error)

    def _on_grabber_features_changed(self, names: frozenset[str]) -> None:
        if self._writing == threading.get_ident():
            self._changed_by_write |= names
        else:
            self._want_changed(names)

    def _want_changed(self, names: Set[str]) -> None:
        with self._lock:
            followed = {name for name in names if self._follows(name)}
            self._stale |= names - followed
            self._want(followed, always=False)

    def _follows(self, name: str) -> bool:
        return name in self._watched or name in self._companions

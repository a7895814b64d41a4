"""The features of a source, and its settings: features with their selectors."""

from __future__ import annotations

import difflib
import logging
import threading
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager

from psygnal import Signal

from grabbergui.core.errors import FeatureNotFoundError, GrabberError
from grabbergui.core.features import AccessCondition, Category, Feature, FeatureValue, format_value
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.settings import Selected, Selectors, SettingKey, ValueChange, WriteResult, same_value
from grabbergui.core.sfnc import Companions, Role

log = logging.getLogger(__name__)


class FeatureSource(ABC):
    """Reads and writes features, one at a time or as settings, which are features with their selectors.

    A call takes as long as the device or the network does; calls of several threads are serialised.
    """

    features_changed = Signal(frozenset)
    """Names (frozenset[str]) of features whose value, range or access may have changed."""
    shared = False
    """Whether others may write its features too, because it is remote or served to a network."""
    info: DeviceInfo

    def __init__(self) -> None:
        self._lock = threading.RLock()
        "Serialises feature calls; held over several that belong together."
        self._restored: frozenset[str] = frozenset()
        "Selectors that the current `exclusive` blocks restore at their end. Protected by the lock."
        self._selectors: Selectors | None = None

    @abstractmethod
    def feature_tree(self) -> Category:
        """Return the root category, without a request to the camera once it is open."""

    @abstractmethod
    def has_feature(self, name: str) -> bool:
        """Return whether the camera's description contains the feature, and the camera implements it."""

    @abstractmethod
    def feature(self, name: str) -> Feature:
        """Return the current feature; from the cache if GenApi's rules allow it.

        Raises FeatureNotFoundError. A feature that cannot be read is no error: see `Feature.access` and
        `Feature.problem`.
        """

    @property
    def reads_at_once(self) -> int:
        """Number of features that `read_features` reads with one request to the camera."""
        return 1

    def read_features(self, names: Sequence[str]) -> list[Feature]:
        """Return features in the order of `names`. Raises as `feature` if one of them does."""
        return [self.feature(name) for name in names]

    def conditions(self, name: str) -> tuple[AccessCondition, ...]:
        """Return which features hide or lock this one, for `Feature.conditions`.

        Empty if none does, or if that is unknown, as for remote sources. May take some milliseconds. Raises
        FeatureNotFoundError.
        """
        return ()

    @abstractmethod
    def write_feature(self, name: str, value: FeatureValue) -> Feature:
        """Write a value (or its text) and return what the camera then reports.

        Switches off an automatic mode of the feature first. Raises FeatureNotFoundError, FeatureAccessError,
        FeatureValueError, FeatureError if the camera refuses, TransportError.
        """

    def pauses_for(self, name: str) -> bool:
        """Return whether writing the feature stops a running stream and starts it again."""
        return False

    @abstractmethod
    def execute(self, name: str) -> None:
        """Run a command feature and wait until the camera reports it done (at most five seconds)."""

    @property
    def selectors(self) -> Selectors:
        """The selectors of each feature, without a request to the camera."""
        tree = self.feature_tree()
        selectors = self._selectors
        if selectors is None or selectors.tree is not tree:
            self._selectors = selectors = Selectors(tree)
        return selectors

    def role(self, role: Role) -> str | None:
        """Return the feature that has a role on this camera, without a request to it; None if none has."""
        return self.selectors.roles.get(role)

    def setting(self, name: str) -> SettingKey:
        """Return the setting that a feature currently shows. May read its selectors."""
        selected = [(selector, self.feature(selector).value) for selector in self.selectors.of(name)]
        return SettingKey(name, tuple((s, format_value(value)) for s, value in selected if value is not None))

    def read_setting(self, key: SettingKey) -> Feature:
        """Select and read a feature, and restore its selectors, in one step.

        No other caller reads or writes a feature of this grabber in between. Raises what `feature` and, for
        the selectors, `write_feature` raise.
        """
        with self._selecting(key.selected):
            return self.feature(key.name)

    def write_setting(self, key: SettingKey, value: FeatureValue) -> WriteResult:
        """Select and write a feature, and restore its selectors, in one step.

        Returns everything that changed. A key without selectors means the currently selected instance. Raises
        what `write_feature` raises.
        """
        with self._lock, self._selecting(key.selected):
            companions = Companions.of(key.name, self.has_feature)
            setting = self.setting(key.name)
            before = self.feature(key.name).value
            # Modes that are off and enablers that are on do not change, so they are not read again: each read
            # is a request to a remote camera.
            switchable = [
                companion
                for companion in map(self.feature, companions.names)
                if companions.impedes(companion.name, companion.value)
            ]
            keys = [self.setting(companion.name) for companion in switchable]
            feature = self.write_feature(key.name, value)
            companions_after = [self.feature(companion.name) for companion in switchable]
            switched = [
                ValueChange(key, old.value, new.value)
                for key, old, new in zip(keys, switchable, companions_after, strict=True)
                if old.value != new.value
            ]
            after = feature.value if feature.value is not None else value
            return WriteResult(
                feature,
                (*switched, ValueChange(setting, before, after)),
                also_changed=tuple(companions_after),
            )

    def execute_setting(self, key: SettingKey) -> None:
        """Select and run a command (`UserSetLoad[UserSetSelector=UserSet1]`) in one step."""
        with self._selecting(key.selected):
            self.execute(key.name)

    @contextmanager
    def exclusive(self, selectors: Iterable[str] = ()) -> Iterator[None]:
        """Let no other caller use features during the block, and restore these selectors after it.

        For several settings that belong together. Other callers wait, so keep it short. A nested block does
        not restore the selectors that the outer one restores.
        """
        with self._lock:
            names = [name for name in selectors if name not in self._restored and self.has_feature(name)]
            before = {name: value for name in names if (value := self.feature(name).value) is not None}
            outer, self._restored = self._restored, self._restored | before.keys()
            try:
                yield
            finally:
                self._restored = outer
                for name, value in before.items():
                    try:
                        self._select(name, format_value(value))
                    except GrabberError as error:
                        log.info("%s could not be restored: %s", name, error)

    def features(self) -> list[Feature]:
        """Return every feature, in the tree's order. May read hundreds of registers."""
        return [self.feature(description.name) for description in self.feature_tree().descriptions()]

    @contextmanager
    def _selecting(self, selected: Selected) -> Iterator[None]:
        if not selected:
            yield
            return
        with self.exclusive(selector for selector, _ in selected):
            for selector, entry in selected:
                self._select(selector, entry)
            yield

    def _select(self, selector: str, entry: str) -> None:
        value = self.feature(selector).value
        if value is None or not same_value(value, entry):
            self.write_feature(selector, entry)

    def _require(self, name: str) -> None:
        if not self.has_feature(name):
            raise self._not_found(name)

    def _not_found(self, name: str) -> FeatureNotFoundError:
        names = [description.name for description in self.feature_tree().descriptions()]
        by_lower = {known.lower(): known for known in names}
        near = difflib.get_close_matches(name.lower(), list(by_lower), n=3, cutoff=0.6)
        hint = f"; did you mean {' or '.join(by_lower[match] for match in near)}?" if near else ""
        return FeatureNotFoundError(f"{self.info.title} has no feature {name[:60]}{hint}", name)

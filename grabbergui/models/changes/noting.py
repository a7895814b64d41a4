"""A grabber that notes what the operator does with it, and what others do meanwhile."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable

from grabbergui.core.errors import FeatureError
from grabbergui.core.features import Feature, FeatureValue
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.sfnc import AUTO_OFF, automatic_mode_of, enabler_of
from grabbergui.core.shared import SharedGrabber
from grabbergui.models.changes.change import Origin
from grabbergui.models.changes.journal import ChangeJournal, Written
from grabbergui.models.settings.feature_set import Selectors, SettingKey, every_instance

log = logging.getLogger(__name__)

CONSEQUENCES = 0.5
"Seconds after a write of ours in which what else moves is taken for its consequence."
MOST_KNOWN = 20_000
"Settings whose last value is remembered."


class NotingGrabber(SharedGrabber):
    """A handle on an open grabber; all that is written or run through it goes into a journal.

    For the thread that makes the grabber's calls. What a write moves besides (an automatic mode that is
    switched off, a switch that is turned on) is noted with it.
    """

    def __init__(
        self, grabber: FrameGrabber, journal: ChangeJournal, clock: Callable[[], float] = time.monotonic
    ) -> None:
        super().__init__(grabber)
        self.journal = journal
        self._others_write = grabber.shared
        self._clock = clock
        self._wrote = float("-inf")
        self._known: dict[SettingKey, FeatureValue] = {}
        self.learn()

    @property
    def plain(self) -> FrameGrabber:
        """The grabber itself: nothing done with it is noted."""
        return self._grabber

    def selectors_of(self, name: str) -> tuple[str, ...]:
        """What selects which instance of a feature is seen, outermost first. Any thread; asks no camera."""
        return self._selectors.of(name)

    def write_feature(self, name: str, value: FeatureValue) -> Feature:
        """See FrameGrabber."""
        feature = self._grabber.feature(name)
        besides = [other for other in (feature.auto, enabler_of(name, self.has_feature)) if other]
        before = {other: self._grabber.feature(other).value for other in besides}
        regulated = self._taken_over(feature)
        self._wrote = self._clock()
        after = self._grabber.write_feature(name, value)
        self._wrote = self._clock()
        written: list[Written] = [
            (self._key(other), before[other], self._grabber.feature(other).value) for other in besides
        ]
        became = after.value if after.value is not None else value
        written.append((self._key(name), feature.value, became))
        for key, _, now in written:
            self._remember(key, now)
        changed = [setting for setting in written if setting[1] != setting[2]]
        # Within a larger step selectors only lead to what is meant, and are put back.
        if changed and not (self.journal.gathering and name in self._choosing):
            self.journal.wrote(changed, regulated)
        return after

    def execute(self, name: str) -> None:
        """See FrameGrabber."""
        self._wrote = self._clock()
        self._grabber.execute(name)
        self._wrote = self._clock()
        self.journal.ran(name)

    def watch(self, feature: Feature) -> None:
        """A feature was read: note what was not changed here. On the same thread.

        What can only be read is left out, unless an automatic mode makes it so: a temperature moves always.
        """
        if feature.value is None or not (feature.access.writable or feature.auto):
            return
        try:
            key = self._key(feature.name)
            known = self._known.get(key)
            self._remember(key, feature.value)
            if known is not None and known != feature.value:
                self.journal.saw(key, known, feature.value, self._origin(feature))
        except FeatureError as error:
            log.debug("a change of %s is not noted: %s", feature.name, error)

    def learn(self) -> None:
        """Look at the grabber's tree, which is another than before."""
        self._selectors = Selectors(self._grabber)
        self._choosing = self._selectors.all_names()
        self._regulates: dict[str, list[str]] = {}
        for name in self._selectors.descriptions:
            if (auto := automatic_mode_of(name, self.has_feature)) is not None:
                self._regulates.setdefault(auto, []).append(name)

    def _taken_over(self, mode: Feature) -> dict[SettingKey, FeatureValue]:
        """What stands by hand until an automatic mode is switched on."""
        if mode.value not in (AUTO_OFF, False):
            return {}
        found: dict[SettingKey, FeatureValue] = {}
        for name in self._regulates.get(mode.name, ()):
            found.update(every_instance(self._grabber, self._selectors, name))
        return found

    def _origin(self, feature: Feature) -> Origin:
        if feature.auto and self._grabber.feature(feature.auto).value not in (AUTO_OFF, False, None):
            return Origin.CAMERA
        others = self._others_write or self._grabber.access is not Access.CONTROL
        ours = self._clock() - self._wrote < CONSEQUENCES
        return Origin.NETWORK if others and not ours else Origin.CAMERA

    def _key(self, name: str) -> SettingKey:
        """The setting that a feature is just now, with its selectors where they stand."""
        path = self._selectors.of(name)
        return SettingKey(name, tuple((s, str(self._grabber.feature(s).value)) for s in path))

    def _remember(self, key: SettingKey, value: FeatureValue | None) -> None:
        if value is None:
            return
        if len(self._known) >= MOST_KNOWN:
            self._known.clear()
        self._known[key] = value

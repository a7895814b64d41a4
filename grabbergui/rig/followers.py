"""Followers: one camera's exposure, gain and white balance lead, the others follow.

So a stereo pair is equally bright while the leader's automatic modes work, or a hand moves its sliders.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import dataclass

from grabbergui.core.errors import GrabberError
from grabbergui.core.feature_instances import instances_of
from grabbergui.core.features import Feature
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.settings import SettingKey
from grabbergui.rig.rig_file import FollowEntry

log = logging.getLogger(__name__)

SAME = 0.002
"Part by which a value may differ from the wanted one before it is written."


@dataclass(frozen=True)
class FollowRule:
    """How a follower's value comes from the leader's."""

    factor: float = 1.0
    limits: tuple[float, float] = (0.0, float("inf"))

    def wanted(self, leading: float, feature: Feature) -> float | None:
        """Return the value to write; None if the follower's is near enough, or cannot be written."""
        value = feature.value
        if not feature.access.writable or isinstance(value, bool) or not isinstance(value, int | float):
            return None
        low, high = self.limits
        wanted = min(max(leading * self.factor, low), high)
        if feature.minimum is not None:
            wanted = max(wanted, float(feature.minimum))
        if feature.maximum is not None:
            wanted = min(wanted, float(feature.maximum))
        if isinstance(value, int):
            step = int(feature.increment or 1)
            wanted = int(feature.minimum or 0) + round((wanted - float(feature.minimum or 0)) / step) * step
        return None if abs(wanted - value) <= SAME * abs(wanted) else wanted


class Followers:
    """Writes the leader's values to the other cameras. One thread calls `follow`; any may set `leader`."""

    def __init__(self, entry: FollowEntry, cameras: Mapping[str, FrameGrabber]) -> None:
        self.leader = entry.leader
        "The name of the camera that the others follow, or empty; may be changed while they do."
        self._entry = entry
        self._cameras = dict(cameras)
        self._problems: dict[str, str] = {}

    def follow(self) -> list[str]:
        """Bring every follower to the leader's values; return what was written, as `right: Gain=3`."""
        written: list[str] = []
        if (leader := self._cameras.get(self.leader)) is None:
            return written
        for name in self._entry.features:
            try:
                keys = instances_of(leader, name) if leader.has_feature(name) else []
                values = {key: leader.read_setting(key).value for key in keys}
            except GrabberError as error:
                log.debug("%s: %s", self.leader, error)
                continue
            for camera, grabber in self._cameras.items():
                if camera != self.leader:
                    for key, value in values.items():
                        written += self._write(camera, grabber, key, value)
        return written

    def _write(self, camera: str, grabber: FrameGrabber, key: SettingKey, value: object) -> list[str]:
        if isinstance(value, bool) or not isinstance(value, int | float) or not grabber.has_feature(key.name):
            return []
        rule = FollowRule()
        if key.name == "ExposureTime":
            limits = self._entry.limits.get(camera, rule.limits)
            rule = FollowRule(self._entry.factors.get(camera, 1.0), limits)
        try:
            wanted = rule.wanted(float(value), grabber.read_setting(key))
            if wanted is None:
                return []
            grabber.write_setting(key, wanted)
        except GrabberError as error:
            if self._problems.get(camera) != str(error):
                self._problems[camera] = str(error)
                log.info("%s does not follow: %s", camera, error)
            return []
        return [f"{camera}: {key}={wanted:g}"]

"""Automatic mode and switch of a feature: its two companions on the camera.

A feature may have an automatic mode (`ExposureAuto`) and a switch (`AcquisitionFrameRateEnable`), or be a
switch itself (`TriggerMode`: On, Off). Both networks use YARP's terms for them.
"""

from __future__ import annotations

from grabbergui.core.companions import automatic_mode_of, enabler_of, offers, regulating
from grabbergui.core.errors import FeatureAccessError
from grabbergui.core.features import Feature, FeatureKind, FeatureValue
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.sfnc import AUTO_CONTINUOUS, AUTO_OFF, AUTO_ONCE

_ON, _OFF = "On", "Off"


class FeatureModes:
    """A grabber's features by GenICam name. Any thread; calls may ask the camera, and raise its errors."""

    def __init__(self, grabber: FrameGrabber) -> None:
        self._grabber = grabber

    # -- what there is -----------------------------------------------------------------------------
    def has_auto(self, name: str) -> bool:
        """Return whether the camera can regulate it by itself."""
        auto = self._automatic(name)
        return auto is not None and (auto.kind is FeatureKind.BOOLEAN or offers(auto, AUTO_CONTINUOUS))

    def has_manual(self, name: str) -> bool:
        """Return whether it can be set, if necessary after its automatic mode was switched off."""
        return self._grabber.feature(name).access.writable or self.has_auto(name)

    def has_one_push(self, name: str) -> bool:
        """Return whether the camera can regulate it once and then keep it."""
        auto = self._automatic(name)
        return auto is not None and offers(auto, AUTO_ONCE)

    def has_on_off(self, name: str) -> bool:
        """Return whether it can be switched on and off."""
        return self._switch(name) is not None

    # -- who regulates it --------------------------------------------------------------------------
    def automatic(self, name: str) -> bool:
        """Return whether the camera regulates it at the moment."""
        return regulating(self._automatic(name))

    def set_automatic(self, name: str, on: bool) -> None:
        """Let the camera regulate it, or keep it as it is."""
        auto = self._automatic(name)
        if auto is None:
            if on:
                raise FeatureAccessError(f"{name} has no automatic mode on this camera", name)
            return
        value = on if auto.kind is FeatureKind.BOOLEAN else AUTO_CONTINUOUS if on else AUTO_OFF
        self._grabber.write_feature(auto.name, value)

    def regulate_once(self, name: str) -> None:
        """Let the camera regulate it once, and then keep it."""
        auto = self._automatic(name)
        if auto is None or not offers(auto, AUTO_ONCE):
            raise FeatureAccessError(f"{name} cannot be regulated once on this camera", name)
        self._grabber.write_feature(auto.name, AUTO_ONCE)

    # -- whether it acts ---------------------------------------------------------------------------
    def active(self, name: str) -> bool:
        """Return whether it is switched on; a feature without a switch is always on."""
        switch = self._switch(name)
        return switch is None or switch.value not in (False, _OFF, None)

    def set_active(self, name: str, on: bool) -> None:
        """Switch it on or off."""
        switch = self._switch(name)
        if switch is None:
            raise FeatureAccessError(f"{name} cannot be switched on and off on this camera", name)
        value: FeatureValue = on if switch.kind is FeatureKind.BOOLEAN else _ON if on else _OFF
        self._grabber.write_feature(switch.name, value)

    # -- inside ------------------------------------------------------------------------------------
    def _automatic(self, name: str) -> Feature | None:
        return self._feature(automatic_mode_of(name, self._grabber.has_feature))

    def _switch(self, name: str) -> Feature | None:
        """Return the feature that switches it: its enabler, or itself if it is On or Off."""
        feature = self._feature(enabler_of(name, self._grabber.has_feature)) or self._grabber.feature(name)
        if feature.kind is FeatureKind.BOOLEAN:
            return feature
        return feature if offers(feature, _ON) and offers(feature, _OFF) else None

    def _feature(self, name: str | None) -> Feature | None:
        return self._grabber.feature(name) if name is not None else None

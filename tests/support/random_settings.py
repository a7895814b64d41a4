"""Random writes to a camera, and the differences that they make in its settings."""

from __future__ import annotations

import random

from grabbergui.core.errors import FeatureError
from grabbergui.core.feature_instances import instances
from grabbergui.core.features import Feature, FeatureKind, FeatureValue
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.identity import describe
from grabbergui.core.settings import SettingKey
from grabbergui.core.sfnc import automatic_mode_of, is_on
from grabbergui.models.change_tracking import every_instance
from grabbergui.models.settings.feature_set import FeatureSet, compare

NOT_WRITTEN = ("DeviceReset", "UserSet", "File", "Ptp", "Gev", "Test")
"Beginnings of names of features that are no settings of the image, or outlive a power loss."


def differences(before: FeatureSet, after: FeatureSet) -> list[str]:
    """Return the differences of two captures, without values that an automatic mode moves by itself.

    An automatic exposure moves the frame rate too: the camera reports no more than the exposure allows.
    """
    names = {key.name for key in before.settings}

    def moves(key: SettingKey) -> bool:
        name = "ExposureTime" if key.name == "AcquisitionFrameRate" else key.name
        mode = automatic_mode_of(name, names.__contains__)
        return mode is not None and is_on(before.settings[SettingKey(mode)])

    return [str(difference) for difference in compare(before, after) if not moves(difference.key)]


def capture_all(camera: FrameGrabber) -> FeatureSet:
    """Capture all settings, also those that the stream locks, which `capture` omits."""
    settings: dict[SettingKey, FeatureValue] = {}
    for description in camera.feature_tree().descriptions():
        if description.streamable:
            settings |= every_instance(camera, description.name)
    return FeatureSet(settings, describe(camera.info), ())


def any_write(camera: FrameGrabber, chance: random.Random) -> None:
    """Write a random value to a random setting; the camera may refuse.

    Nothing regulates once on a running stream: it might end between the look before and the loss.
    """
    names = [
        d.name
        for d in camera.feature_tree().descriptions()
        if (d.streamable or d.name in camera.selectors.names) and not d.name.startswith(NOT_WRITTEN)
    ]
    name = chance.choice(names)
    found = instances(camera, camera.selectors.of(name))[0]
    if not found:
        return
    key = SettingKey(name, chance.choice(found) if chance.random() < 0.5 else ())
    try:
        feature = camera.read_setting(key)
        value = any_value(feature, chance)
        if not (camera.streaming and value == "Once"):
            camera.write_setting(key, value)
    except FeatureError:
        pass


def any_value(feature: Feature, chance: random.Random) -> FeatureValue:
    if feature.kind is FeatureKind.BOOLEAN:
        return chance.random() < 0.5
    if feature.kind is FeatureKind.ENUMERATION:
        entries = [entry.name for entry in feature.entries if entry.available]
        return chance.choice(entries) if entries else ""
    if feature.kind is FeatureKind.STRING or feature.minimum is None:
        return ""
    if feature.kind is FeatureKind.FLOAT:
        return chance.uniform(feature.minimum, min(feature.maximum, 50_000.0))
    step = int(feature.increment or 1)
    return feature.minimum + chance.randrange((feature.maximum - feature.minimum) // step + 1) * step

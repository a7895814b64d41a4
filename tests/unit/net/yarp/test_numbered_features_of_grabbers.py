"""YARP's numbered features on grabbers with modern and with old names."""

from __future__ import annotations

import re
import threading
from dataclasses import replace
from pathlib import Path

import pytest

from fakes import ScriptedGrabber
from grabbergui.core.errors import FeatureAccessError, FeatureError, FeatureNotFoundError, FeatureValueError
from grabbergui.core.features import AccessMode, EnumEntry, Feature, FeatureKind
from grabbergui.net.numbered_features import ROLES, FeatureId, FeatureMode, NumberedFeatures
from patience import PATIENCE


def number(name: str, value: float, low: float | None, high: float | None, **more: object) -> Feature:
    kind = FeatureKind.INTEGER if isinstance(value, int) else FeatureKind.FLOAT
    return Feature(
        name=name,
        kind=kind,
        access=AccessMode.READ_WRITE,
        value=value,
        minimum=low,
        maximum=high,
        **more,  # type: ignore[arg-type]
    )


def choice(name: str, value: str, *entries: str) -> Feature:
    return Feature(
        name=name,
        kind=FeatureKind.ENUMERATION,
        access=AccessMode.READ_WRITE,
        value=value,
        entries=tuple(map(EnumEntry, entries)),
    )


def switch(name: str, value: bool) -> Feature:
    return Feature(name=name, kind=FeatureKind.BOOLEAN, access=AccessMode.READ_WRITE, value=value)


class BalancedGrabber(ScriptedGrabber):
    """Has one balance ratio for each entry of its selector."""

    def __init__(self, *features: Feature) -> None:
        super().__init__(
            [
                *features,
                choice("BalanceRatioSelector", "Green", "Red", "Green", "Blue"),
                number("BalanceRatio", 1.0, 0.5, 4.5, selectors=("BalanceRatioSelector",)),
            ]
        )
        self.ratios = {"Red": 1.5, "Green": 1.0, "Blue": 2.0}

    def feature(self, name: str) -> Feature:
        feature = super().feature(name)
        if name != "BalanceRatio":
            return feature
        return replace(feature, value=self.ratios[str(self.known["BalanceRatioSelector"].value)])

    def write_feature(self, name: str, value: float | bool | str) -> Feature:
        written = super().write_feature(name, value)
        if name == "BalanceRatio":
            self.ratios[str(self.known["BalanceRatioSelector"].value)] = float(written.value or 0)
        return written


@pytest.fixture
def grabber() -> BalancedGrabber:
    return BalancedGrabber(
        number("ExposureTime", 1000.0, 10.0, 20010.0, unit="us"),
        choice("ExposureAuto", "Off", "Off", "Once", "Continuous"),
        number("GainRaw", 5, 0, 100, increment=5),
        choice("GainAuto", "Off", "Off", "Continuous"),
        number("AcquisitionFrameRate", 25.0, 0.5, 100.0),
        switch("AcquisitionFrameRateEnable", True),
        choice("TriggerMode", "Off", "Off", "On"),
        switch("ReverseX", False),
        replace(number("DeviceTemperature", 41.5, None, None), access=AccessMode.READ_ONLY),
    )


@pytest.fixture
def features(grabber: BalancedGrabber) -> NumberedFeatures:
    return NumberedFeatures(grabber)


def test_every_number_has_a_role() -> None:
    assert set(ROLES) == set(FeatureId)


def test_the_manual_lists_every_number() -> None:
    manual = (Path(__file__).parents[4] / "docs" / "yarp.md").read_text("utf-8")
    rows = [line.split("|")[1:4] for line in manual.splitlines() if re.match(r"\| \d", line)]
    documented = {int(number): names for ids, _, names in rows for number in ids.split(",")}
    assert set(documented) == set(FeatureId)
    for feature, role in ROLES.items():
        assert role.names[0] in documented[feature]


def test_numbers_find_modern_and_old_names(features: NumberedFeatures) -> None:
    assert features.name(FeatureId.EXPOSURE) == "ExposureTime"
    assert features.name(FeatureId.SHUTTER) == "ExposureTime"
    assert features.name(FeatureId.GAIN) == "GainRaw"
    assert features.name(FeatureId.IRIS) is None
    assert features.name(99) is None


def test_the_camera_has_these_features(features: NumberedFeatures) -> None:
    there = {feature for feature in FeatureId if features.has(feature)}
    assert there == {
        *(FeatureId.EXPOSURE, FeatureId.SHUTTER, FeatureId.GAIN, FeatureId.FRAME_RATE),
        *(FeatureId.TRIGGER, FeatureId.MIRROR, FeatureId.TEMPERATURE, FeatureId.WHITE_BALANCE),
    }
    assert [f for f in FeatureId if features.has_auto(f)] == [
        *(FeatureId.EXPOSURE, FeatureId.SHUTTER, FeatureId.GAIN),
    ]
    assert features.has_one_push(FeatureId.EXPOSURE)
    assert not features.has_one_push(FeatureId.GAIN)
    assert [f for f in FeatureId if features.has_on_off(f)] == [
        *(FeatureId.TRIGGER, FeatureId.FRAME_RATE, FeatureId.MIRROR),
    ]
    assert not features.has_manual(FeatureId.TEMPERATURE)
    assert features.has_manual(FeatureId.GAIN)
    assert not any((features.has(-1), features.has(23), features.has_auto(2**31 - 1)))


def test_a_feature_locked_by_its_automatic_mode_can_be_set(
    grabber: BalancedGrabber, features: NumberedFeatures
) -> None:
    grabber.set("ExposureAuto", "Continuous")
    grabber.set("ExposureTime", access=AccessMode.READ_ONLY)
    assert features.has_manual(FeatureId.EXPOSURE)


def test_values_in_the_cameras_own_units(grabber: BalancedGrabber, features: NumberedFeatures) -> None:
    assert features.value(FeatureId.EXPOSURE) == 1000.0
    assert features.values(FeatureId.EXPOSURE) == (10.0, 20010.0)
    features.set_value(FeatureId.EXPOSURE, 0.1 + 0.2 + 10)
    assert grabber.known["ExposureTime"].value == 0.1 + 0.2 + 10
    with pytest.raises(FeatureValueError, match=r"10 … 20010 us"):
        features.set_value(FeatureId.EXPOSURE, 9.0)
    with pytest.raises(FeatureValueError):
        features.set_value(FeatureId.EXPOSURE, float("nan"))
    with pytest.raises(FeatureValueError):
        features.set_value(FeatureId.GAIN, float("inf"))


def test_whole_numbers_go_to_the_nearest_step(grabber: BalancedGrabber, features: NumberedFeatures) -> None:
    features.set_value(FeatureId.GAIN, 12.6)
    assert grabber.known["GainRaw"].value == 15


def test_normalised_values_go_from_0_to_1_over_the_range_of_the_feature(grabber: BalancedGrabber) -> None:
    features = NumberedFeatures(grabber, normalised=True)
    assert features.value(FeatureId.EXPOSURE) == pytest.approx(990 / 20000)
    features.set_value(FeatureId.EXPOSURE, 0.5)
    assert grabber.known["ExposureTime"].value == 10010.0
    features.set_value(FeatureId.GAIN, 1.0)
    assert grabber.known["GainRaw"].value == 100
    with pytest.raises(FeatureValueError, match=r"0 … 1"):
        features.set_value(FeatureId.EXPOSURE, 500.0)
    with pytest.raises(FeatureAccessError):  # a range would be taken for the camera's own units
        features.values(FeatureId.EXPOSURE)
    assert features.values(FeatureId.WHITE_BALANCE) == (0.25, 0.375)
    # No range to normalise by.
    assert features.value(FeatureId.TEMPERATURE) == 41.5


def test_white_balance_is_red_and_blue(grabber: BalancedGrabber, features: NumberedFeatures) -> None:
    assert features.values(FeatureId.WHITE_BALANCE) == (1.5, 2.0)
    features.set_values(FeatureId.WHITE_BALANCE, 3.0, 4.0)
    assert grabber.ratios == {"Red": 3.0, "Green": 1.0, "Blue": 4.0}
    assert grabber.known["BalanceRatioSelector"].value == "Green"
    with pytest.raises(FeatureValueError):
        features.set_values(FeatureId.WHITE_BALANCE, 3.0, 40.0)
    assert grabber.known["BalanceRatioSelector"].value == "Green"
    with pytest.raises(FeatureAccessError, match="two values"):
        features.value(FeatureId.WHITE_BALANCE)
    with pytest.raises(FeatureAccessError, match="one value"):
        features.set_values(FeatureId.GAIN, 1, 2)


def test_red_is_restored_if_blue_is_refused(grabber: BalancedGrabber, features: NumberedFeatures) -> None:
    with pytest.raises(FeatureValueError):
        features.set_values(FeatureId.WHITE_BALANCE, 3.0, 40.0)
    assert grabber.ratios == {"Red": 1.5, "Green": 1.0, "Blue": 2.0}


def test_two_networks_do_not_select_between_each_others_steps(
    grabber: BalancedGrabber, features: NumberedFeatures, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[tuple[float, float]] = []
    other = NumberedFeatures(grabber)
    reader = threading.Thread(target=lambda: seen.append(other.values(FeatureId.WHITE_BALANCE)))
    write = grabber.write_feature

    def write_while_the_other_reads(name: str, value: float | bool | str) -> Feature:
        if name == "BalanceRatio" and reader.ident is None:
            reader.start()
            reader.join(0.1)
            assert not seen
        return write(name, value)

    monkeypatch.setattr(grabber, "write_feature", write_while_the_other_reads)
    features.set_values(FeatureId.WHITE_BALANCE, 3.0, 4.0)
    reader.join(PATIENCE)

    assert grabber.ratios == {"Red": 3.0, "Green": 1.0, "Blue": 4.0}
    assert len(seen) == 1 and seen[0][0] == 3.0


def test_a_balance_without_red_and_blue_is_none() -> None:
    features = NumberedFeatures(ScriptedGrabber([number("BalanceRatio", 1.0, 0.5, 4.0)]))
    assert not features.has(FeatureId.WHITE_BALANCE)


def test_a_mode_is_the_automatic_feature_and_one_push_is_its_once(
    grabber: BalancedGrabber, features: NumberedFeatures
) -> None:
    assert features.mode(FeatureId.EXPOSURE) is FeatureMode.MANUAL
    features.set_mode(FeatureId.EXPOSURE, FeatureMode.AUTO)
    assert grabber.known["ExposureAuto"].value == "Continuous"
    assert features.mode(FeatureId.EXPOSURE) is FeatureMode.AUTO
    features.set_mode(FeatureId.EXPOSURE, FeatureMode.MANUAL)
    assert grabber.known["ExposureAuto"].value == "Off"
    features.one_push(FeatureId.EXPOSURE)
    assert grabber.known["ExposureAuto"].value == "Once"
    features.set_mode(FeatureId.MIRROR, FeatureMode.MANUAL)
    for refused in (
        lambda: features.set_mode(FeatureId.EXPOSURE, 7),
        lambda: features.set_mode(FeatureId.MIRROR, FeatureMode.AUTO),
        lambda: features.one_push(FeatureId.GAIN),
    ):
        with pytest.raises(FeatureError):
            refused()


def test_switching_a_feature_writes_its_enabler(grabber: BalancedGrabber, features: NumberedFeatures) -> None:
    assert features.active(FeatureId.FRAME_RATE)
    features.set_active(FeatureId.FRAME_RATE, False)
    assert grabber.known["AcquisitionFrameRateEnable"].value is False
    assert not features.active(FeatureId.FRAME_RATE)
    features.set_active(FeatureId.TRIGGER, True)
    assert grabber.known["TriggerMode"].value == "On"
    assert features.value(FeatureId.TRIGGER) == 1.0
    assert features.active(FeatureId.GAIN)
    with pytest.raises(FeatureAccessError, match="switch"):
        features.set_active(FeatureId.GAIN, False)


def test_booleans_and_choices_count_from_zero(grabber: BalancedGrabber, features: NumberedFeatures) -> None:
    features.set_value(FeatureId.MIRROR, 1.0)
    assert grabber.known["ReverseX"].value is True
    assert features.values(FeatureId.MIRROR) == (0.0, 1.0)
    with pytest.raises(FeatureValueError, match=r"0 … 1"):
        features.set_value(FeatureId.TRIGGER, 2)


def test_text_has_no_number() -> None:
    name = ROLES[FeatureId.OPTICAL_FILTER].names[0]
    text = Feature(name=name, kind=FeatureKind.STRING, access=AccessMode.READ_WRITE, value="near")
    features = NumberedFeatures(ScriptedGrabber([text]))
    with pytest.raises(FeatureAccessError, match="is text"):
        features.value(FeatureId.OPTICAL_FILTER)


def test_missing_features_are_named(features: NumberedFeatures) -> None:
    for missing, name in ((FeatureId.IRIS, "iris"), (77, "feature number 77")):
        with pytest.raises(FeatureNotFoundError, match=name):
            features.value(missing)
        with pytest.raises(FeatureNotFoundError):
            features.mode(missing)
        with pytest.raises(FeatureNotFoundError):
            features.set_active(missing, True)

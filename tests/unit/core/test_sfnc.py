"""Roles of features, their companions, and what has to be written to these."""

import pytest

from every_case import every_case
from fakes import ScriptedGrabber
from grabbergui.core import sfnc
from grabbergui.core.errors import FeatureAccessError
from grabbergui.core.features import AccessMode, EnumEntry, Feature, FeatureDescription, FeatureKind
from grabbergui.core.frame_period import frame_period, frame_wait
from grabbergui.core.settings import SettingKey, ValueChange
from grabbergui.core.sfnc import Companions, Role


@every_case(
    ("role", "camera", "found"),
    [
        (Role.EXPOSURE, {"ExposureTime", "ExposureTimeAbs"}, "ExposureTime"),
        (Role.EXPOSURE, {"ExposureTimeAbs", "ExposureTimeRaw"}, "ExposureTimeAbs"),
        (Role.GAIN, {"GainRaw"}, "GainRaw"),
        (Role.FRAME_RATE, {"AcquisitionFrameRateAbs"}, "AcquisitionFrameRateAbs"),
        (Role.GAMMA, {"Gain"}, None),
        (Role.EXPOSURE, {"ManualDirectShutter"}, "ManualDirectShutter"),
        (Role.EXPOSURE, {"MANUALDIRECTSHUTTER", "GAIN"}, "MANUALDIRECTSHUTTER"),
        (Role.FRAME_RATE, {"FPS", "AcquisitionLineRate"}, "FPS"),
        (Role.FRAME_RATE, {"AcquisitionLineRate"}, "AcquisitionLineRate"),
        (Role.GAIN, {"DigitalGain", "AnalogGain"}, "AnalogGain"),
        (Role.GAIN, {"DigitalGain"}, "DigitalGain"),
        (Role.FRAME_RATE, {"SensorFrameRate"}, "SensorFrameRate"),
        (Role.FRAME_RATE, {"ConstantFrameRate"}, "ConstantFrameRate"),
        (Role.EXPOSURE, {"exposure_time", "gain"}, "exposure_time"),
        (Role.GAIN, {"exposure_time", "gain"}, "gain"),
        (Role.FRAME_RATE, {"frame_rate"}, "frame_rate"),
    ],
)
def test_the_best_name_a_camera_has(role, camera, found):
    described = [FeatureDescription(name=name, kind=FeatureKind.FLOAT) for name in camera]
    assert sfnc.features_by_role(described).get(role) == found


@pytest.mark.parametrize(
    ("role", "camera", "found"),
    [
        (Role.FRAME_RATE, {"ConstantFrameRate": FeatureKind.BOOLEAN}, None),
        (Role.FRAME_RATE, {"ConstantFrameRate": FeatureKind.BOOLEAN, "FPS": FeatureKind.FLOAT}, "FPS"),
        (Role.FRAME_RATE, {"FPS": FeatureKind.ENUMERATION}, "FPS"),
        (
            Role.EXPOSURE,
            {"Shutter": FeatureKind.ENUMERATION, "exposure_time": FeatureKind.FLOAT},
            "exposure_time",
        ),
        (Role.GAIN, {"Gain": FeatureKind.STRING}, None),
        (Role.MIRROR, {"ReverseX": FeatureKind.BOOLEAN}, "ReverseX"),
        (Role.TRIGGER, {"TriggerMode": FeatureKind.COMMAND}, None),
    ],
)
def test_a_role_needs_a_feature_of_its_kind(role, camera, found):
    described = [FeatureDescription(name=name, kind=kind) for name, kind in camera.items()]
    assert sfnc.features_by_role(described).get(role) == found


@pytest.mark.parametrize(
    ("name", "camera", "auto"),
    [
        ("ExposureTime", {"ExposureAuto"}, "ExposureAuto"),
        ("ExposureTimeRaw", {"ExposureAuto"}, "ExposureAuto"),
        ("Gain", {"ExposureAuto"}, None),
        ("Focus", {"FocusAuto"}, "FocusAuto"),
        ("BalanceRatioAbs", {"BalanceWhiteAuto"}, "BalanceWhiteAuto"),
    ],
)
def test_the_automatic_mode_of_a_feature(name, camera, auto):
    assert sfnc.automatic_mode_of(name, camera.__contains__) == auto


def test_the_enabler_of_the_frame_rate():
    has = {"AcquisitionFrameRateEnabled"}.__contains__
    assert sfnc.enabler_of("AcquisitionFrameRate", has) == "AcquisitionFrameRateEnabled"
    assert sfnc.enabler_of("Gain", has) is None


def test_the_role_of_a_name():
    assert sfnc.role_of("GainRaw") is sfnc.role_of("GAINRAW") is Role.GAIN
    assert sfnc.role_of("LineSelector") is None


def test_no_name_has_two_roles():
    names = [name for role in Role for name in role.names]
    assert len(names) == len({name.lower() for name in names})


def mode(value="Continuous", entries=("Off", "Continuous"), access=AccessMode.READ_WRITE, available=True):
    known = tuple(EnumEntry(name, available=available) for name in entries)
    return Feature(name="GainAuto", kind=FeatureKind.ENUMERATION, access=access, value=value, entries=known)


def switch(value, access=AccessMode.READ_WRITE, kind=FeatureKind.BOOLEAN):
    return Feature(name="GammaEnable", kind=kind, access=access, value=value)


@every_case(
    ("name", "known", "expected"),
    [
        ("ExposureTime", {"ExposureAuto"}, Companions("ExposureAuto")),
        ("ExposureTimeAbs", {"ExposureAuto"}, Companions("ExposureAuto")),
        ("ExposureTimeAbs", {"ExposureTimeEnable"}, Companions(None, "ExposureTimeEnable")),
        ("GainRaw", {"GainAuto", "Gain"}, Companions("GainAuto")),
        ("BalanceRatio", {"BalanceWhiteAuto"}, Companions("BalanceWhiteAuto")),
        ("BalanceRatio", {"BalanceRatioAuto"}, Companions("BalanceRatioAuto")),
        ("Focus", {"FocusAuto"}, Companions("FocusAuto")),
        ("AcquisitionFrameRate", {"AcquisitionFrameRateEnable", "AcquisitionFrameRateAuto"},
         Companions("AcquisitionFrameRateAuto", "AcquisitionFrameRateEnable")),
        ("FrameRateAbs", {"FrameRateEnabled"}, Companions(None, "FrameRateEnabled")),
        ("Gamma", {"GammaEnable", "GammaEnabled"}, Companions(None, "GammaEnable")),
        ("Width", {"Height", "ExposureAuto"}, Companions()),
    ],
)  # fmt: skip
def test_companions_are_found_by_their_names(name, known, expected):
    found = Companions.of(name, known.__contains__)
    assert found == expected
    assert found.names == tuple(part for part in (expected.mode, expected.enabler) if part)


def test_a_mode_regulates_every_feature_that_names_it():
    known = ["ExposureTime", "ExposureAuto", "Gain", "GainRaw", "GainAuto", "Width"]
    found = sfnc.regulated_by_mode(known, known.__contains__)
    assert found == {"ExposureAuto": ["ExposureTime"], "GainAuto": ["Gain", "GainRaw"]}


@pytest.mark.parametrize(
    ("value", "on"), [("Off", False), (False, False), (None, False), ("Once", True), (True, True)]
)
def test_the_values_that_count_as_on(value, on):
    assert sfnc.is_on(value) is on
    assert sfnc.regulating(mode(value)) is on


def test_no_mode_regulates_nothing():
    assert not sfnc.regulating(None)


def test_only_an_enumeration_offers_entries():
    assert sfnc.offers(mode(), "Continuous")
    assert not sfnc.offers(mode(), "Once")
    assert not sfnc.offers(switch(True), "Continuous")


@pytest.mark.parametrize(
    ("feature", "write"),
    [
        (mode(), ("GainAuto", "Off")),
        (mode("Off"), None),
        (mode(access=AccessMode.READ_ONLY), None),
        (mode(entries=("Never", "Continuous")), None),
        (mode(available=False), None),
        (switch(True), ("GammaEnable", False)),
    ],
)
def test_a_mode_is_switched_off_by_its_type(feature, write):
    assert sfnc.switched_off(feature) == write


@pytest.mark.parametrize(
    ("feature", "write"),
    [
        (switch(False), ("GammaEnable", True)),
        (switch(True), None),
        (switch(False, AccessMode.READ_ONLY), None),
        (switch(None), None),
        (switch(0, kind=FeatureKind.INTEGER), None),
    ],
)
def test_an_enabler_is_switched_on(feature, write):
    assert sfnc.switched_on(feature) == write


@pytest.mark.parametrize(
    ("access", "auto", "regulator", "editable"),
    [
        (AccessMode.READ_ONLY, "GainAuto", mode(), True),
        (AccessMode.READ_ONLY, "GainAuto", mode("Off"), False),
        (AccessMode.READ_ONLY, "GainAuto", mode(access=AccessMode.READ_ONLY), False),
        (AccessMode.READ_ONLY, "ExposureAuto", mode(), False),
        (AccessMode.READ_ONLY, "GainAuto", None, False),
        (AccessMode.NOT_AVAILABLE, "GainAuto", mode(), False),
    ],
)
def test_only_a_features_own_mode_does_not_lock_it(access, auto, regulator, editable):
    gain = Feature(name="Gain", kind=FeatureKind.FLOAT, access=access, value=1.0, auto=auto)
    offered = sfnc.as_editable(gain, regulator)
    assert offered.access is (AccessMode.READ_WRITE if editable else access)
    assert offered.value == 1.0


def test_a_write_returns_what_it_changed_with_its_companions():
    gain = Feature(
        name="Gain", kind=FeatureKind.FLOAT, access=AccessMode.READ_WRITE, value=1.0, minimum=0.0, maximum=9.0
    )
    grabber = ScriptedGrabber([gain, mode()])

    def off(name, value):
        if name == "Gain":
            grabber.set("GainAuto", "Off")
        return value

    grabber.on_write = off
    first = grabber.write_setting(SettingKey("Gain"), 2.0)
    assert first.feature.value == 2.0
    assert first.written == (
        ValueChange(SettingKey("GainAuto"), "Continuous", "Off"),
        ValueChange(SettingKey("Gain"), 1.0, 2.0),
    )
    assert [feature.value for feature in first.also_changed] == ["Off"]
    grabber.reads.clear()
    again = grabber.write_setting(SettingKey("Gain"), 3.0)
    assert grabber.reads.count("GainAuto") == 1  # off already: not read again after the write
    assert again.written == (ValueChange(SettingKey("Gain"), 2.0, 3.0),)


def number(name, value, unit=""):
    return Feature(name=name, kind=FeatureKind.FLOAT, value=value, unit=unit, access=AccessMode.READ_WRITE)


def flag(name, *, value):
    return Feature(name=name, kind=FeatureKind.BOOLEAN, value=value, access=AccessMode.READ_WRITE)


@every_case(
    ("features", "seconds"),
    [
        ([], 0.0),
        ([number("AcquisitionFrameRate", 25.0, "Hz")], 0.04),
        ([number("AcquisitionFrameRate", 25.0, "Hz"), number("ExposureTime", 8e6, "us")], 8.0),
        ([number("AcquisitionFrameRate", 0.1, "Hz"), number("ExposureTime", 100.0, "us")], 10.0),
        ([number("AcquisitionFrameRate", 0.1), number("AcquisitionResultingFrameRate", 20.0)], 0.05),
        ([number("AcquisitionFrameRate", 0.0), number("ExposureTimeRaw", 2000)], 0.002),
        ([number("AcquisitionFrameRateRaw", 7.0), number("Shutter", 2.0, "ticks")], 0.0),
        ([number("AcquisitionFrameRate", None), number("ExposureTime", None, "us")], 0.0),
        ([number("AcquisitionFrameRate", 25.0, "Hz"), number("ExposureTime", 8.0, "s")], 8.0),
        ([number("AcquisitionFrameRate", 25.0, "Hz"), number("ExposureTime", 80.0, "ms")], 0.08),
        ([number("ExposureTime", 50.0, "\N{GREEK SMALL LETTER MU}s")], 5e-5),
        ([number("AcquisitionLineRate", 1000.0, "Hz"), number("Height", 500)], 0.5),
        ([flag("ConstantFrameRate", value=False)], 0.0),
        ([flag("FrameRate", value=True), number("ExposureTime", 2e6)], 2.0),
    ],
)
def test_the_frame_period_is_the_longer_of_rate_and_exposure(features, seconds):
    camera = ScriptedGrabber(features)
    assert frame_period(camera) == pytest.approx(seconds)
    assert frame_wait(camera, 1.0) == pytest.approx(1.0 + 2 * seconds)


def test_the_frame_period_of_a_camera_that_does_not_answer_is_unknown():
    camera = ScriptedGrabber([number("AcquisitionFrameRate", 25.0)])
    camera.failures["AcquisitionFrameRate"] = FeatureAccessError("busy", "AcquisitionFrameRate")
    assert frame_period(camera) == 0

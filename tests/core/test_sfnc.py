import pytest

from grabbergui.core import companions, sfnc
from grabbergui.core.sfnc import Role


@pytest.mark.parametrize(
    ("role", "camera", "found"),
    [
        (Role.EXPOSURE, {"ExposureTime", "ExposureTimeAbs"}, "ExposureTime"),
        (Role.EXPOSURE, {"ExposureTimeAbs", "ExposureTimeRaw"}, "ExposureTimeAbs"),
        (Role.GAIN, {"GainRaw"}, "GainRaw"),
        (Role.FRAME_RATE, {"AcquisitionFrameRateAbs"}, "AcquisitionFrameRateAbs"),
        (Role.GAMMA, {"Gain"}, None),
        (Role.EXPOSURE, {"ManualDirectShutter"}, "ManualDirectShutter"),
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
    assert role.find(camera.__contains__) == found


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
    assert companions.automatic_mode_of(name, camera.__contains__) == auto


def test_the_enabler_of_the_frame_rate():
    has = {"AcquisitionFrameRateEnabled"}.__contains__
    assert companions.enabler_of("AcquisitionFrameRate", has) == "AcquisitionFrameRateEnabled"
    assert companions.enabler_of("Gain", has) is None


def test_what_a_name_is_for():
    assert sfnc.role_of("GainRaw") is Role.GAIN
    assert sfnc.role_of("LineSelector") is None


def test_no_name_has_two_roles():
    names = [name for role in Role for name in role.names]
    assert len(names) == len(set(names))

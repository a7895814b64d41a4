"""The services of grabber_interfaces, called by a node that knows nothing of us."""

import json
import threading

import pytest

pytest.importorskip("rclpy", reason="ROS 2 is not installed: make setup-ros2")
pytest.importorskip("grabber_interfaces", reason="the interface package is not built: make setup-ros2")
pytestmark = pytest.mark.ros2

from grabber_interfaces import srv  # noqa: E402
from std_srvs.srv import Trigger  # noqa: E402

from grabbergui import sources  # noqa: E402
from grabbergui.core.settings import SettingKey  # noqa: E402
from grabbergui.net.ros2.server import Ros2GrabberServer  # noqa: E402
from grabbergui.terminal import remote_terminal  # noqa: E402
from patience import PATIENCE  # noqa: E402
from ros2_peers import Probe, until  # noqa: E402
from second_writer import BALANCE, OTHERS, others_stay, ratio  # noqa: E402

WHITE_BALANCE, GAIN, TRIGGER, FRAME_RATE = 3, 8, 12, 15
MANUAL, AUTO, ONCE, ON, OFF = range(1, 6)


@pytest.fixture(scope="module")
def camera():
    grabber = sources.create("sim:?width=64&height=48&pixel_format=BayerRG8")
    grabber.open()
    yield grabber
    grabber.close()


@pytest.fixture(scope="module")
def probe(camera, domain):
    with Ros2GrabberServer(camera, "/cam", terminal=remote_terminal(camera)):
        probe = Probe()
        yield probe
        probe.close()


@pytest.fixture
def streaming(camera):
    """The camera in colour, streaming, whatever the tests before left."""
    camera.stop()
    camera.write_feature("PixelFormat", "BayerRG8")
    camera.start()
    yield camera
    camera.stop()


@pytest.fixture
def call(probe):
    def call(kind, **request):
        name = "".join(f"_{c.lower()}" if c.isupper() else c for c in kind.__name__).strip("_")
        return probe.call(kind, f"/cam/{name}", **request)

    return call


@pytest.mark.parametrize("which", [{"feature": GAIN}, {"name": "Gain"}, {"feature": 0, "name": "Gain"}])
def test_a_number_and_a_name_mean_the_same_and_the_name_wins(call, camera, which):
    assert call(srv.SetMode, mode=MANUAL, **which).success
    has = call(srv.HasFeature, **which)
    assert (has.success, has.has_feature, has.has_auto, has.has_one_push, has.has_manual) == (True,) * 5
    assert not has.has_on_off

    answer = call(srv.SetFeature, value=5.0, **which)

    assert (answer.success, answer.value, answer.text) == (True, 5.0, "5")
    assert camera.feature("Gain").value == 5
    answer = call(srv.GetFeature, **which)
    assert (answer.value, answer.unit, answer.mode, answer.active) == (5.0, "dB", MANUAL, True)
    answer = call(srv.GetFeatureRange, **which)
    assert (answer.minimum, answer.maximum, answer.unit, answer.writable) == (0.0, 24.0, "dB", True)


def test_a_feature_that_only_the_stream_locks_can_be_written(call, camera):
    camera.start()
    try:
        assert call(srv.GetFeatureRange, name="PixelFormat").writable
        assert not call(srv.GetFeatureRange, name="SensorWidth").writable
        assert call(srv.GetFeature, name="PixelFormat").mode == MANUAL
    finally:
        camera.stop()


@pytest.mark.parametrize("which", [{"feature": GAIN}, {"name": "Gain"}])
def test_a_mode_is_set_and_read_by_number_and_by_name(call, camera, which):
    assert call(srv.SetMode, mode=AUTO, **which).success
    assert camera.feature("GainAuto").value == "Continuous"
    assert call(srv.GetFeature, **which).mode == AUTO
    assert call(srv.SetMode, mode=MANUAL, **which).success and camera.feature("GainAuto").value == "Off"
    assert call(srv.SetMode, mode=ONCE, **which).success


@pytest.mark.parametrize("which", [{"feature": FRAME_RATE}, {"name": "AcquisitionFrameRate"}])
def test_a_switch_in_addition_to_the_feature(call, camera, which):
    assert call(srv.HasFeature, **which).has_on_off
    assert call(srv.SetMode, mode=OFF, **which).success
    assert camera.feature("AcquisitionFrameRateEnable").value is False
    assert not call(srv.GetFeature, **which).active
    assert call(srv.SetMode, mode=ON, **which).success
    assert camera.feature("AcquisitionFrameRateEnable").value is True
    assert call(srv.GetFeature, **which).active


@pytest.mark.parametrize("which", [{"feature": TRIGGER}, {"name": "TriggerMode"}])
def test_a_feature_that_is_a_switch(call, camera, which):
    assert call(srv.HasFeature, **which).has_on_off
    assert call(srv.SetMode, mode=ON, **which).success and camera.feature("TriggerMode").value == "On"
    assert call(srv.GetFeature, **which).active
    assert call(srv.SetMode, mode=OFF, **which).success and camera.feature("TriggerMode").value == "Off"


def test_a_boolean_is_a_switch(call, camera):
    assert call(srv.SetMode, name="ReverseX", mode=ON).success and camera.feature("ReverseX").value is True
    assert call(srv.SetFeature, name="ReverseX", value=0.0).text == "false"


def test_white_balance_is_a_pair(call, camera):
    selector = camera.feature("BalanceRatioSelector").value

    answer = call(srv.SetFeature, feature=WHITE_BALANCE, value=1.5, second_value=2.5)

    assert answer.success, answer.message
    assert (answer.value, answer.second_value) == (1.5, 2.5)
    answer = call(srv.GetFeature, feature=WHITE_BALANCE)
    assert (answer.value, answer.second_value, answer.text) == (1.5, 2.5, "1.5 2.5")
    assert camera.feature("BalanceRatioSelector").value == selector
    assert call(srv.SetMode, feature=WHITE_BALANCE, mode=AUTO).success
    assert camera.feature("BalanceWhiteAuto").value == "Continuous"
    refused = call(srv.SetFeature, feature=WHITE_BALANCE, value=1.0, second_value=1000.0)
    assert not refused.success and "allowed:" in refused.message


def test_lines_of_a_remote_terminal(call):
    answer = call(srv.Ask, verb="terminal", arguments=["get SensorWidth"])
    assert answer.success and "SensorWidth = " in answer.result
    answer = call(srv.Ask, verb="terminal", arguments=["save camera.yaml"])
    assert not answer.success and "save" in answer.result


def test_choices_go_by_text_and_by_place(call, camera):
    assert call(srv.SetFeature, name="PixelFormat", text="Mono12").text == "Mono12"
    entries = call(srv.GetFeatureRange, name="ExposureAuto").entries
    assert entries == ["Off", "Once", "Continuous"]
    assert call(srv.SetFeature, name="ExposureAuto", value=2.0).text == "Continuous"
    assert not call(srv.SetFeature, name="ExposureAuto", value=1.5).success
    assert call(srv.SetFeature, name="ExposureAuto", text="Off").success


def test_a_text_may_be_empty(call, camera):
    assert call(srv.SetFeature, name="DeviceUserID", text="left").text == "left"
    answer = call(srv.SetFeature, name="DeviceUserID", text="", value=3.0)
    assert (answer.success, answer.text) == (True, "") and camera.feature("DeviceUserID").value == ""


@pytest.mark.parametrize(
    ("kind", "request_", "message"),
    [
        (srv.SetFeature, {"name": "Gain", "value": 99.0}, "allowed: 0 … 24 dB"),
        (srv.SetFeature, {"name": "Gain", "value": float("nan")}, "not a finite number"),
        (srv.SetFeature, {"name": "Width", "value": float("inf")}, "Width=inf"),
        (srv.SetFeature, {"name": "ExposureAuto", "value": float("nan")}, "entries are counted 0 … 2"),
        (srv.SetFeature, {"name": "SensorWidth", "value": 3.0}, "read-only"),
        (srv.GetFeature, {"name": "Gian"}, "did you mean Gain"),
        (srv.GetFeature, {"feature": 4711}, "feature number 4711"),
        (srv.GetFeature, {}, "which feature?"),
        (srv.HasFeature, {}, "which feature?"),
        (srv.SetFeature, {"value": 1.0}, "which feature?"),
        (srv.GetFeatureRange, {"feature": 10}, "has no focus"),
        (srv.SetMode, {"name": "Gain", "mode": 9}, "mode 9 is none of 1 … 5"),
        (srv.SetMode, {"name": "Gain", "mode": ON}, "cannot be switched on and off"),
        (srv.SetMode, {"name": "Width", "mode": AUTO}, "has no automatic mode"),
        (srv.SetMode, {"name": "Width", "mode": ONCE}, "cannot be regulated once"),
    ],
)
def test_failures_are_replies(call, kind, request_, message):
    answer = call(kind, **request_)

    assert not answer.success and message in answer.message


def test_the_camera_lacks_these_features(call):
    assert not call(srv.HasFeature, name="Warp").has_feature
    assert not call(srv.HasFeature, feature=10).has_feature


def test_selecting_and_writing_are_one_step(call, camera):
    """A red gain never lands in green, though somebody else moves the selector all the time."""
    camera.write_feature("PixelFormat", "BayerRG8")
    with others_stay(camera):
        for number in range(15):
            red, blue = 2 + number / 100, OTHERS["Blue"]
            answer = call(srv.SetFeature, feature=WHITE_BALANCE, value=red, second_value=blue)
            assert (answer.success, answer.value, answer.second_value) == (True, pytest.approx(red), blue)
            answer = call(srv.Ask, verb="set", arguments=[str(ratio("Red")), str(red + 1)])
            assert answer.success and json.loads(answer.result)["feature"]["value"] == pytest.approx(red + 1)


def test_the_answer_is_of_the_instance_that_was_written(call, camera, monkeypatch):
    camera.write_feature("PixelFormat", "BayerRG8")
    camera.write_setting(ratio("Blue"), OTHERS["Blue"])
    camera.write_feature(BALANCE, "Red")
    write = camera.write_feature
    others = threading.Thread(target=write, args=(BALANCE, "Blue"))

    def write_and_be_followed(name, value):
        feature = write(name, value)
        others.start()
        others.join(0.3)
        return feature

    monkeypatch.setattr(camera, "write_feature", write_and_be_followed)
    answer = call(srv.SetFeature, name="BalanceRatio", value=2.5)
    others.join()
    assert (answer.success, answer.value) == (True, 2.5)
    assert camera.feature("BalanceRatio").value == OTHERS["Blue"]


def test_the_stream_stops_and_starts(probe, camera):
    assert probe.call(Trigger, "/cam/stop").success
    assert not camera.streaming
    assert probe.call(Trigger, "/cam/start").success
    assert camera.streaming


def test_a_trigger_gives_one_image(probe, camera):
    from sensor_msgs.msg import Image

    camera.write_setting(SettingKey("TriggerMode", (("TriggerSelector", "FrameStart"),)), "On")
    camera.write_setting(SettingKey("TriggerSource", (("TriggerSelector", "FrameStart"),)), "Software")
    try:
        images = probe.subscribe(Image, "/cam/image_raw")
        until(lambda: probe.call(Trigger, "/cam/trigger").success and images.qsize() >= 3)
    finally:
        camera.write_setting(SettingKey("TriggerMode", (("TriggerSelector", "FrameStart"),)), "Off")


@pytest.mark.parametrize(
    ("service", "mode"),
    [
        ("exposure_once", "ExposureAuto"),
        ("gain_once", "GainAuto"),
        ("white_balance_once", "BalanceWhiteAuto"),
    ],
)
def test_one_push_regulates_once(probe, streaming, service, mode):
    camera = streaming
    camera.write_feature(mode, "Continuous")
    assert probe.call(Trigger, f"/cam/{service}").success
    assert camera.feature(mode).value in ("Once", "Off")


def test_user_sets_are_saved_and_loaded_though_the_camera_streams(probe, streaming):
    camera = streaming
    before = camera.feature("Gain").value
    camera.write_feature("Gain", 7)
    assert probe.call(Trigger, "/cam/user_sets/UserSet1/save").success
    camera.write_feature("Gain", 1)
    assert probe.call(Trigger, "/cam/user_sets/UserSet1/load").success
    assert camera.feature("Gain").value == 7 and camera.streaming
    offered = dict(probe.node.get_service_names_and_types())
    assert "/cam/user_sets/Default/load" in offered and "/cam/user_sets/Default/save" not in offered
    camera.write_feature("Gain", before)


def test_metadata_have_the_stamp_of_their_image(probe, streaming):
    camera = streaming
    from diagnostic_msgs.msg import DiagnosticArray
    from sensor_msgs.msg import Image

    camera.write_feature("ChunkModeActive", True)
    camera.write_feature("ExposureTime", 1234)
    images = probe.subscribe(Image, "/cam/image_raw")
    metadata = probe.subscribe(DiagnosticArray, "/cam/image_raw/metadata")

    def described():
        message = metadata.get(timeout=PATIENCE)
        values = {pair.key: pair.value for pair in message.status[0].values}
        return values.get("ChunkExposureTime") == "1234" and (message.header, values)

    header, values = until(described)
    assert values["ExposureTime"] == "1234 us" and values["DeviceTemperature"].endswith(" C")
    assert int(values["FrameID"]) > 0 and header.frame_id == "camera"
    stamps = {(header.stamp.sec, header.stamp.nanosec)}

    def joined():
        stamp = metadata.get(timeout=PATIENCE).header.stamp
        stamps.add((stamp.sec, stamp.nanosec))
        stamp = images.get(timeout=PATIENCE).header.stamp
        return (stamp.sec, stamp.nanosec) in stamps

    until(joined)

"""Our client on other people's camera drivers: controls from parameters, odd and wrong messages."""

import queue
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest

pytest.importorskip("rclpy", reason="ROS 2 is not installed: make setup-ros2")
pytest.importorskip("grabber_interfaces", reason="the interface package is not built: make setup-ros2")
pytestmark = pytest.mark.ros2

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult  # noqa: E402
from rclpy.parameter import Parameter  # noqa: E402
from rclpy.qos import ReliabilityPolicy  # noqa: E402
from sensor_msgs.msg import CameraInfo, CompressedImage, Image, RegionOfInterest  # noqa: E402

from grabbergui import sources  # noqa: E402
from grabbergui.core.errors import (  # noqa: E402
    FeatureNotFoundError,
    FeatureValueError,
    RemoteProtocolError,
    SourceNotFoundError,
    UsageError,
)
from grabbergui.core.features import FeatureKind  # noqa: E402
from grabbergui.core.grabber import ConnectionState  # noqa: E402
from grabbergui.net.ros2 import client  # noqa: E402
from grabbergui.net.ros2.client_link import CameraLink, not_found, publishers_of  # noqa: E402
from grabbergui.net.ros2.runtime import Ros2Node  # noqa: E402
from other_driver import DEEP, depth, image, information, jpeg, png, said  # noqa: E402
from patience import PATIENCE, attempts  # noqa: E402
from ros2_peers import until  # noqa: E402


def test_parameters_become_controls(driver, opened):
    span = FloatingPointRange(from_value=1.0, to_value=9.0, step=0.0)
    steps = IntegerRange(from_value=0, to_value=16, step=4)
    declare = driver.node.declare_parameter
    declare("exposure", 2.0, ParameterDescriptor(description="how bright", floating_point_range=[span]))
    declare("rgb.binning", 4, ParameterDescriptor(integer_range=[steps]))
    declare("rgb.flip", False)
    declare("name", "left")
    declare("serial", "4711", ParameterDescriptor(read_only=True))
    declare("awb", "auto", ParameterDescriptor(additional_constraints="one of [off, auto, daylight]"))
    declare("anti_flicker", 50, ParameterDescriptor(description="Mains, in Hz. Valid values: 0, 50 or 60"))
    declare("power_line", 1, ParameterDescriptor(description="0: Disabled, 1: 50 Hz, 2: 60 Hz"))
    declare("matrix", [1.0, 2.5])
    declare("modes", ["off", "größer"], ParameterDescriptor(read_only=True))

    remote = opened("ros2:/other")

    branches = {branch.name: [m.name for m in branch.members] for branch in remote.feature_tree().members}
    assert branches["rgb"] == ["rgb.binning", "rgb.flip"]
    assert branches["Parameters"] == [
        "exposure",
        "name",
        "serial",
        "awb",
        "anti_flicker",
        "power_line",
        "matrix",
        "modes",
    ]
    exposure = remote.feature("exposure")
    assert (exposure.kind, exposure.value, exposure.tooltip) == (FeatureKind.FLOAT, 2.0, "how bright")
    assert (exposure.minimum, exposure.maximum) == (1.0, 9.0)
    binning = remote.feature("rgb.binning")
    assert (binning.kind, binning.minimum, binning.maximum, binning.increment) == (
        FeatureKind.INTEGER,
        0,
        16,
        4,
    )
    assert remote.feature("rgb.flip").kind is FeatureKind.BOOLEAN
    assert remote.feature("name").kind is FeatureKind.STRING
    assert not remote.feature("serial").access.writable
    assert remote.feature("serial").access_problem() == "is read-only"
    line = remote.feature("power_line")
    assert [entry.name for entry in line.entries] == ["Disabled", "50 Hz", "60 Hz"] and line.value == "50 Hz"
    assert remote.write_feature("power_line", "60 Hz").value == "60 Hz"
    assert driver.node.get_parameter("power_line").value == 2
    matrix = remote.feature("matrix")
    assert (matrix.kind, matrix.value) == (FeatureKind.STRING, "[1.0, 2.5]")
    assert remote.feature("modes").value == '["off", "größer"]'
    assert not remote.feature("modes").access.writable
    awb, flicker = remote.feature("awb"), remote.feature("anti_flicker")
    assert [entry.name for entry in awb.entries] == ["off", "auto", "daylight"] and awb.value == "auto"
    assert [entry.name for entry in flicker.entries] == ["0", "50", "60"] and flicker.value == "50"


def test_a_driver_that_is_started_with_other_parameters_has_these(driver, drive, opened):
    driver.node.declare_parameter("gain", 3)
    remote = opened("ros2:/other")
    states = queue.Queue()
    remote.connection_changed.connect(lambda state, why: states.put(state))
    assert remote.has_feature("gain")
    remote.start()

    driver.close()
    assert states.get(timeout=PATIENCE) is ConnectionState.LOST
    drive().node.declare_parameter("gamma", 1.0)

    assert states.get(timeout=PATIENCE) is ConnectionState.OPEN
    assert [description.name for description in remote.feature_tree().descriptions()] == ["gamma"]


def test_a_node_that_does_not_say_whether_it_set_a_parameter(driver, opened, monkeypatch):
    driver.node.declare_parameter("gain", 3)
    remote = opened("ros2:/other")
    call = CameraLink._call_parameters

    def without_results(link, service, request):
        answer = call(link, service, request)
        if service == "set_parameters":
            answer.results = []
        return answer

    monkeypatch.setattr(CameraLink, "_call_parameters", without_results)
    monkeypatch.setattr(remote._link.features, "_call", remote._link._call_parameters)
    with pytest.raises(RemoteProtocolError, match="gain=4"):
        remote.write_feature("gain", 4)


def test_controls_set_parameters(driver, opened):
    span = FloatingPointRange(from_value=1.0, to_value=9.0, step=0.0)
    driver.node.declare_parameter("exposure", 2.0, ParameterDescriptor(floating_point_range=[span]))
    driver.node.declare_parameter("flip", False)
    driver.node.declare_parameter("name", "left")
    driver.node.declare_parameter("rate", 50, ParameterDescriptor(description="one of 50, 60"))
    driver.node.add_on_set_parameters_callback(
        lambda parameters: SetParametersResult(
            successful=not any(p.value == "taken" for p in parameters), reason="that name is taken"
        )
    )
    remote = opened("ros2:/other")

    assert remote.write_feature("exposure", "4.5").value == 4.5
    assert remote.write_feature("flip", True).value is True
    assert remote.write_feature("name", "").value == ""
    assert remote.write_feature("rate", "60").value == "60"

    assert driver.node.get_parameter("rate").value == 60
    with pytest.raises(FeatureValueError, match="allowed: 1 … 9"):
        remote.write_feature("exposure", 10)
    with pytest.raises(FeatureValueError, match="that name is taken"):
        remote.write_feature("name", "taken")
    with pytest.raises(FeatureValueError, match="no command"):
        remote.execute("flip")


def test_a_parameter_that_changes_its_type_can_be_set_as_what_it_is_now(driver, opened):
    driver.node.declare_parameter("mode", 3, ParameterDescriptor(dynamic_typing=True))
    remote = opened("ros2:/other")
    assert remote.feature("mode").kind is FeatureKind.INTEGER

    driver.node.set_parameters([Parameter("mode", value="three")])
    until(lambda: remote.feature("mode").kind is FeatureKind.STRING)

    assert remote.write_feature("mode", "four").value == "four"
    assert driver.node.get_parameter("mode").value == "four"


@pytest.mark.parametrize(
    ("before", "text", "after", "shown"),
    [
        ([1.0], "[0.5, 2]", [0.5, 2.0], "[0.5, 2.0]"),
        ([1], "3, -4", [3, -4], "[3, -4]"),
        ([True], "[false, true]", [False, True], "[false, true]"),
        (["a"], '["left, right", ""]', ["left, right", ""], '["left, right", ""]'),
        ([b"\x01"], "[0, 255]", [b"\x00", b"\xff"], "[0, 255]"),
        ([1.0], "[]", [], "[]"),
    ],
)
def test_arrays_are_edited_as_text(driver, opened, before, text, after, shown):
    driver.node.declare_parameter("list", before)
    remote = opened("ros2:/other")

    assert remote.write_feature("list", text).value == shown

    parameter = driver.node.get_parameter("list")
    assert list(parameter.value) == after and parameter.type_ == Parameter("list", value=before).type_
    with pytest.raises(FeatureValueError, match="write a list as"):
        remote.write_feature("list", "[{}]")


def test_changes_by_the_driver_are_reported_with_their_new_range(driver, opened):
    driver.node.declare_parameter("gain", 2, ParameterDescriptor(integer_range=[IntegerRange(to_value=9)]))
    remote = opened("ros2:/other")
    reported = queue.Queue()
    remote.features_changed.connect(reported.put)

    def changed():
        wider = ParameterDescriptor(type=2, integer_range=[IntegerRange(to_value=20)])
        driver.node.set_descriptor("gain", wider)
        driver.node.set_parameters([Parameter("gain", value=15)])
        return not reported.empty()

    until(changed)

    assert reported.get() == frozenset({"gain"})
    gain = remote.feature("gain")
    assert (gain.value, gain.maximum) == (15, 20)


def test_a_node_without_parameters_is_an_image_only(opened, drive, monkeypatch):
    drive("bare", start_parameter_services=False)
    monkeypatch.setattr("grabbergui.net.ros2.client_link.SETTLED", 0.5)
    remote = opened("ros2:/bare")
    frames = remote.open_queue()
    remote.start()

    assert frames.get(PATIENCE).raw().shape == (2, 4)
    assert not list(remote.feature_tree().descriptions())
    with pytest.raises(FeatureNotFoundError):
        remote.feature("exposure")


def test_a_node_that_answers_no_service_is_an_image_only(opened, notices, drive, monkeypatch):
    """As a program that publishes from its own loop and never spins."""
    drive("mute", callbacks=False)
    monkeypatch.setattr("grabbergui.net.ros2.client_link.FIRST_ANSWER", 0.5)
    remote = opened("ros2:/mute")
    frames = remote.open_queue()
    remote.start()

    assert frames.get(PATIENCE).raw().shape == (2, 4)
    assert said(notices, "/mute/image_raw is shown without controls")()


def test_a_node_without_parameters_is_opened_soon(drive, monkeypatch):
    """As are others whose services were discovered; the rest is looked for while the images are shown."""
    drive("bare", start_parameter_services=False)
    monkeypatch.setattr("grabbergui.net.ros2.client_link.SETTLED", 1.0)
    for watch in attempts(2.5):
        remote = sources.create("ros2:/bare")
        with watch:
            remote.open()
        remote.close()


def test_controls_that_answer_only_later_are_added(opened, drive, monkeypatch):
    """As those of a driver that starts its camera before it spins, or whose services are discovered late."""
    monkeypatch.setattr("grabbergui.net.ros2.client_link.FIRST_ANSWER", 0.5)
    monkeypatch.setattr("grabbergui.net.ros2.client.LATE_CONTROLS", PATIENCE)
    driver = drive("tardy", callbacks=False)
    driver.node.declare_parameter("gain", 15)
    remote = opened("ros2:/tardy")
    changed = queue.Queue()
    remote.features_changed.connect(changed.put)
    frames = remote.open_queue()
    remote.start()
    assert frames.get(PATIENCE).width == 4 and not remote.has_feature("gain")

    driver.ros.start()
    until(lambda: "gain" in changed.get(timeout=PATIENCE))
    assert remote.feature("gain").value == 15 and frames.get(PATIENCE).width == 4


def test_sixteen_that_answer_no_service_are_sixteen_images(opened, domain, monkeypatch):
    monkeypatch.setattr("grabbergui.net.ros2.client_link.FIRST_ANSWER", 0.5)
    mute = Ros2Node("mute_drivers")  # never started: nothing of it answers
    publishers = [mute.node.create_publisher(Image, f"/mute{number}/image_raw", 5) for number in range(16)]
    with ThreadPoolExecutor(16) as pool:
        cameras = list(pool.map(opened, [f"ros2:/mute{number}" for number in range(16)]))
    queues = [camera.open_queue() for camera in cameras]
    for camera in cameras:
        camera.start()

    def all_seen():
        for publisher in publishers:
            publisher.publish(image())
        return all(camera.statistics().frames for camera in cameras)

    until(all_seen)
    assert [queue.get(PATIENCE).width for queue in queues] == [4] * 16
    mute.close()


def test_a_publisher_outside_ros_has_no_name_and_is_shown(opened, notices, drive, monkeypatch):
    drive("other")
    monkeypatch.setattr("grabbergui.net.ros2.client.NAME_TIMEOUT", 0.1)
    monkeypatch.setattr(
        "grabbergui.net.ros2.client_link.publishers_of",
        lambda node, topic: [replace(found, node="") for found in publishers_of(node, topic)],
    )
    remote = opened("ros2:/other")
    frames = remote.open_queue()
    remote.start()

    assert frames.get(PATIENCE).width == 4
    assert said(notices, "its publisher offers no parameters")()


def test_of_two_cameras_of_one_name_image_raw_is_opened_and_the_other_is_named(drive, opened, notices):
    with ThreadPoolExecutor() as pool:
        drive(topic="image", node="view")
        opening = pool.submit(opened, "ros2:/other")
        drive()
        remote = opening.result(PATIENCE)
    assert remote.info.address == "/other/image_raw" and remote.info.model == "/other_driver"
    until(said(notices, "/other/image is another node's: open ros2:/other/image to see it"))
    assert opened("ros2:/other/image").info.model == "/view"


def test_a_camera_of_the_same_name_that_is_discovered_later_is_named(drive, opened, notices):
    driver = drive(topic="image", node="view")
    remote = opened("ros2:/other")
    assert remote.info.address == "/other/image"
    drive()
    until(said(notices, "/other/image_raw is another node's"))

    states = queue.Queue()
    remote.connection_changed.connect(lambda state, why: states.put(state))
    driver.close()
    assert states.get(timeout=PATIENCE) is ConnectionState.LOST
    drive(topic="image", node="view")
    assert states.get(timeout=PATIENCE) is ConnectionState.OPEN
    assert remote.info.model == "/view"


def test_two_cameras_of_one_name_are_listed_apart(drive):
    from grabbergui.net.ros2 import client

    drive(topic="image", node="view")
    until(lambda: listed(client) == {"ros2:/other"})
    driver = drive()
    until(lambda: listed(client) == {"ros2:/other/image", "ros2:/other/image_raw"})
    driver.close()
    until(lambda: listed(client) == {"ros2:/other"})


def listed(client):
    return {info.uri for info in client.discover(1.0) if "/other" in info.uri}


def test_lines_may_be_padded(driver, opened):
    remote = opened("ros2:/other")
    frames = remote.open_queue()
    remote.start()

    assert frames.get(PATIENCE).raw().tolist() == [[0, 1, 2, 3], [8, 9, 10, 11]]


def test_the_drivers_camera_info_is_used(driver, opened, notices):
    remote = opened("ros2:/other")
    remote.start()
    driver.info = information()
    assert until(remote.calibration).matrix[0, 0] == 500

    driver.info = information(
        roi=RegionOfInterest(x_offset=64, y_offset=32, width=320, height=240), binning_x=2, binning_y=2
    )
    until(lambda: remote.calibration().width == 160)
    driver.info = CameraInfo(width=640, height=480)
    until(lambda: remote.calibration() is None)
    assert not said(notices, "camera_info")()
    driver.info = information()
    driver.info.distortion_model, driver.info.d = "double_sphere", [0.0] * 4
    until(said(notices, "distortion model 'double_sphere'"))


def test_the_publishers_quality_of_service_is_shown(driver, opened, notices):
    remote = opened("ros2:/other")

    assert remote.info.interface == "/other_driver (reliable, volatile)"
    assert said(notices, "/other/image_raw comes from /other_driver (reliable, volatile)")()


def test_a_publisher_that_cannot_be_reliable_is_reported_and_shown(opened, notices, drive):
    drive(reliability=ReliabilityPolicy.BEST_EFFORT)
    remote = opened("ros2:/other?qos=reliable")
    frames = remote.open_queue()
    remote.start()

    frames.get(PATIENCE)

    assert said(notices, "/other_driver (best effort, volatile) cannot send reliably")()


def test_reliable_where_it_can_be_had(driver, opened, notices):
    remote = opened("ros2:/other?qos=reliable")
    remote.start()

    subscription = until(lambda: driver.node.get_subscriptions_info_by_topic("/other/image_raw"))[0]
    assert subscription.qos_profile.reliability == ReliabilityPolicy.RELIABLE
    with pytest.raises(UsageError, match="sensor_data or reliable"):
        sources.create("ros2:/other?qos=best")


def test_an_encoding_that_cannot_be_shown_is_named_and_the_next_good_image_is_shown(driver, opened, notices):
    driver.message = image(encoding="64FC4")
    remote = opened("ros2:/other")
    frames = remote.open_queue()
    remote.start()
    until(said(notices, "encoding '64FC4' cannot be shown"))
    assert remote.statistics().incomplete > 0

    driver.message = image()

    assert frames.get(PATIENCE).width == 4


def test_images_that_contradict_themselves_are_refused(driver, opened, notices):
    driver.message = image(width=400)
    remote = opened("ros2:/other")
    remote.start()

    until(said(notices, "contradicts itself"))


def test_a_changed_size_is_reported(driver, opened, notices):
    remote = opened("ros2:/other")
    frames = remote.open_queue()
    remote.start()
    frames.get(PATIENCE)

    driver.message = image(2, 2)

    until(said(notices, "images are 2×2 Mono8 now, they were 4×2 Mono8"))
    until(lambda: frames.get(PATIENCE).width == 2)


def test_a_clock_that_jumps_back_is_reported_and_arrival_times_are_used(driver, opened, notices):
    remote = opened("ros2:/other")
    frames = remote.open_queue()
    begun = time.time_ns()
    remote.start()
    assert begun - 2e9 < frames.get(PATIENCE).received_ns < time.time_ns()

    driver.stamp = lambda: time.time() - 3600

    until(said(notices, "stamps went back by 60 min"))
    until(said(notices, "60 min behind this machine's clock"))
    until(lambda: frames.get(PATIENCE).timestamp_ns < time.time_ns() - 3e12)
    assert begun < frames.get(PATIENCE).received_ns < time.time_ns()


def test_two_publishers_of_one_topic_are_reported(driver, opened, notices):
    remote = opened("ros2:/other")
    remote.start()
    frames = remote.open_queue()
    second = Ros2Node("second_driver")
    images = second.node.create_publisher(Image, "/other/image_raw", 5)
    until(lambda: len(publishers_of(remote._ros.node, "/other/image_raw")) == 2)
    looks = remote.statistics().frames + 100
    until(lambda: frames.get(PATIENCE) and remote.statistics().frames > looks)
    assert not said(notices, "their images mix")()  # a killed one is listed, too

    until(lambda: images.publish(image()) or said(notices, "their images mix")())
    second.close()


def test_a_topic_of_something_else_is_named(drive, probe):
    drive("info", kind=CameraInfo)

    until(lambda: "carries sensor_msgs/msg/CameraInfo" in not_found(probe.node, "/info/image_raw"))


@pytest.mark.parametrize(
    ("last", "message", "pixel_format"),
    [
        ("image_raw/compressed", jpeg("bgr8; jpeg compressed bgr8"), "BGR8"),
        ("image_raw/compressed", jpeg("jpeg", 1), "Mono8"),
        ("image_rect/compressed", png("mono16; png compressed mono16"), "Mono16"),
        ("depth/compressedDepth", depth("16UC1; compressedDepth png"), "Coord3D_C16"),
    ],
    ids=str,
)
def test_compressed_images_are_a_source(drive, opened, last, message, pixel_format):
    """As a bag, or a camera behind a slow network, may have nothing else."""
    driver = drive("small", kind=CompressedImage, topic=last)
    driver.message = message
    driver.info = information()
    uri = f"ros2:/small/{last}"
    until(lambda: uri in [info.uri for info in client.discover(0.3)])

    remote = opened(uri)
    frames = remote.open_queue()
    remote.start()

    frame = frames.get(PATIENCE)
    assert (frame.width, frame.height, frame.pixel_format.name) == (4, 2, pixel_format)
    if pixel_format.endswith("16"):
        assert frame.raw().tolist() == DEEP
    until(lambda: remote.calibration())


def test_a_camera_with_plain_images_is_one_source(drive, opened):
    drive("both")
    drive("both", kind=CompressedImage, topic="image_raw/compressed", node="republisher")
    until(lambda: len([info for info in client.discover(0.3) if "/both" in info.uri]) == 1)
    assert opened("ros2:/both")._link.topic == "/both/image_raw"


def test_a_damaged_compressed_image_is_reported(drive, opened, notices):
    driver = drive("broken", kind=CompressedImage, topic="image_raw/compressed")
    driver.message = CompressedImage(format="jpeg", data=b"\xff\xd8 no JPEG")
    remote = opened("ros2:/broken")
    remote.start()
    until(said(notices, "a compressed image ('jpeg')"))
    assert remote.statistics().incomplete


def test_a_topic_that_is_not_there(impatience):
    with pytest.raises(SourceNotFoundError, match="nobody publishes images at /nowhere/image_raw"):
        sources.create("ros2:/nowhere").open()
    with pytest.raises(UsageError, match="which topic"):
        sources.create("ros2:")


def test_nothing_listens_after_stop(driver, opened):
    remote = opened("ros2:/other")
    remote.start()
    until(lambda: driver.node.count_subscribers("/other/image_raw"))

    remote.stop()

    until(lambda: not driver.node.count_subscribers("/other/image_raw"))
    assert not remote.streaming

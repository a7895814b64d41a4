"""Features as parameters, asked by rclpy's own parameter client, which `ros2 param` stands on."""

import math
import re
from contextlib import closing

import pytest

pytest.importorskip("rclpy", reason="ROS 2 is not installed: make setup-ros2")
pytest.importorskip("grabber_interfaces", reason="the interface package is not built: make setup-ros2")
pytestmark = pytest.mark.ros2

from rcl_interfaces.msg import Parameter as ParameterMessage  # noqa: E402
from rcl_interfaces.msg import ParameterEvent, ParameterType, ParameterValue  # noqa: E402
from sensor_msgs.msg import Image  # noqa: E402

from fakes import ScriptedGrabber  # noqa: E402
from grabbergui import sources  # noqa: E402
from grabbergui.core.errors import UsageError  # noqa: E402
from grabbergui.core.features import AccessMode, EnumEntry, Feature, FeatureKind, Visibility  # noqa: E402
from grabbergui.core.requester import requester  # noqa: E402
from grabbergui.models.peer_grabber import PeerGrabber  # noqa: E402
from grabbergui.net.ros2.server import Ros2GrabberServer  # noqa: E402
from patience import PATIENCE, attempts  # noqa: E402
from ros2_peers import ParameterProbe, until  # noqa: E402
from second_writer import BALANCE, others_stay, ratio  # noqa: E402


@pytest.fixture(scope="module")
def camera():
    grabber = sources.create("sim:?width=320&height=240&fps=50")
    grabber.open()
    yield grabber
    grabber.close()


@pytest.fixture(scope="module")
def server(camera, domain):
    with Ros2GrabberServer(camera, "/cam") as server:
        yield server


@pytest.fixture(scope="module")
def parameters(server):
    probe = ParameterProbe("/cam")
    yield probe
    probe.close()


def test_every_feature_with_a_value_is_listed_with_rclpys_own_parameters(parameters, camera):
    names = parameters.names()

    features = [
        d.name
        for d in camera.feature_tree().descriptions()
        if d.kind is not FeatureKind.COMMAND and d.visibility is not Visibility.INVISIBLE
    ]
    assert "TLParamsLocked" not in features
    assert names[: len(features)] == features
    assert {"use_sim_time", "qos_overrides./cam/image_raw.publisher.depth"} <= set(names[len(features) :])


def test_a_list_by_prefix(parameters):
    assert parameters.names(["Gain"]) == ["Gain"]
    assert all(name.startswith("qos_overrides.") for name in parameters.names(["qos_overrides"]))
    assert "Gain" in parameters.names(None, 1)


def test_features_are_parameters_of_their_type(parameters, camera):
    gain, width, auto, reverse, latch = parameters.values(
        "Gain", "Width", "GainAuto", "ReverseX", "use_sim_time"
    )

    assert (gain.double_value, width.integer_value, auto.string_value) == (0.0, 320, "Off")
    assert (reverse.type, reverse.bool_value) == (ParameterType.PARAMETER_BOOL, False)
    assert latch.type == ParameterType.PARAMETER_BOOL
    assert parameters.types("Gain", "Width", "GainAuto", "use_sim_time") == [3, 2, 4, 1]


def test_the_author_of_a_change_is_the_node_that_made_it(camera, domain):
    peers, authors = PeerGrabber(camera), []
    peers.written.connect(lambda result: authors.append(requester()))
    with (
        closing(peers),
        Ros2GrabberServer(peers, "/authored"),
        closing(ParameterProbe("/authored")) as probe,
    ):

        def named():
            """Discovery may list a client's node a moment after the client works."""
            assert probe.set(Gain=1.0)[0].successful and probe.set(Gain=0.0)[0].successful
            return authors[-1].startswith("/")

        until(named)
        assert authors[-1] == probe.node.get_fully_qualified_name()


def test_an_unknown_name_empties_the_answer_as_in_rclpy(parameters):
    assert not parameters.values("Gain", "Gian")
    assert not parameters.types("TimestampLatch")
    assert not parameters.describe("Gian")


def test_descriptors_say_range_unit_entries_and_who_may_write(parameters, camera):
    gain, width, auto, sensor = parameters.describe("Gain", "Width", "GainAuto", "SensorWidth")

    assert (gain.floating_point_range[0].from_value, gain.floating_point_range[0].to_value) == (0.0, 24.0)
    assert "in dB" in gain.description and not gain.read_only
    assert width.type == ParameterType.PARAMETER_INTEGER
    assert width.integer_range[0].step == camera.feature("Width").increment > 1
    assert auto.additional_constraints == "one of Off, Once, Continuous"
    assert sensor.read_only and "read-only" in sensor.additional_constraints


def test_a_feature_that_only_the_stream_locks_can_be_set(parameters, camera):
    assert camera.streaming

    described = parameters.describe("PixelFormat", "Height", "HeightMax", "AcquisitionMode")

    assert [descriptor.read_only for descriptor in described] == [False, False, True, False]
    assert described[0].additional_constraints.startswith("one of Mono8")
    assert parameters.set(Height=64)[0].successful and camera.streaming


def test_the_read_only_flag_and_the_range_follow_the_camera(domain):
    knob = Feature(
        name="Knob", kind=FeatureKind.INTEGER, access=AccessMode.READ_ONLY, value=3, minimum=0, maximum=9
    )
    grabber = ScriptedGrabber([knob])
    with Ros2GrabberServer(grabber, "/scripted"), closing(ParameterProbe("/scripted")) as parameters:
        assert parameters.describe("Knob")[0].read_only
        assert not parameters.set(Knob=4)[0].successful

        grabber.set("Knob", 8, access=AccessMode.READ_WRITE, maximum=20)

        (descriptor,) = parameters.describe("Knob")
        assert not descriptor.read_only and descriptor.integer_range[0].to_value == 20
        assert parameters.values("Knob")[0].integer_value == 8
        assert parameters.set(Knob=15)[0].successful and grabber.known["Knob"].value == 15


def test_a_feature_that_its_automatic_mode_locks_is_not_read_only(domain):
    entries = (EnumEntry("Off"), EnumEntry("Continuous"))
    knob = Feature(
        name="Gain", kind=FeatureKind.FLOAT, access=AccessMode.READ_ONLY, value=1.0, auto="GainAuto"
    )
    auto = Feature(
        name="GainAuto",
        kind=FeatureKind.ENUMERATION,
        access=AccessMode.READ_WRITE,
        value="Continuous",
        entries=entries,
    )
    grabber = ScriptedGrabber([knob, auto])
    with Ros2GrabberServer(grabber, "/scripted"), closing(ParameterProbe("/scripted")) as parameters:
        assert not parameters.describe("Gain")[0].read_only
        grabber.set("GainAuto", "Off")
        assert parameters.describe("Gain")[0].read_only


def test_a_feature_that_cannot_be_read_is_reported_as_not_set(parameters, camera):
    hidden = [f for f in camera.features() if f.value is None and f.kind is not FeatureKind.COMMAND]
    assert hidden

    values = parameters.values(*(feature.name for feature in hidden))

    assert [value.type for value in values] == [ParameterType.PARAMETER_NOT_SET] * len(hidden)


def test_setting_parameters_writes_features(parameters, camera):
    assert parameters.set(Gain=7.5, Width=64)[1].successful
    assert (camera.feature("Gain").value, camera.feature("Width").value) == (7.5, 64)


@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("Gain", 99.5, "allowed: 0 … 24 dB"),
        ("Width", 17, "not on the step"),
        ("GainAuto", "Sometimes", "one of Off, Once, Continuous"),
        ("SensorWidth", 5, "read-only"),
        ("Gian", 1.0, "did you mean Gain"),
        ("Gain", "5", "is a double, not a string"),
        ("Width", 64.0, "is an integer, not a double"),
        ("ReverseX", 1, "is a boolean, not an integer"),
        ("Gain", [1.0, 2.0], "is a double, not an array"),
        ("Gain", None, "belongs to the camera and cannot be deleted"),
        ("TimestampLatch", True, "is a command"),
        ("use_sim_time", 3, "Wrong parameter type"),
    ],
)
def test_impossible_values_are_refused_with_the_reason(parameters, name, value, reason):
    (result,) = parameters.set(**{name: value})

    assert not result.successful and reason in result.reason


def test_a_type_that_ros_does_not_have_is_refused(parameters):
    for name in ("Gain", "use_sim_time"):
        result = parameters.set_message(ParameterMessage(name=name, value=ParameterValue(type=77)))
        assert not result.successful and result.reason


def test_words_that_ros2_param_misreads_are_put_right(parameters, camera):
    """`ros2 param set /cam GainAuto Off` sends false, `… Gain 5` an integer."""
    camera.write_feature("GainAuto", "Continuous")

    assert parameters.set(GainAuto=False)[0].successful and camera.feature("GainAuto").value == "Off"
    assert parameters.set(Gain=5)[0].successful and camera.feature("Gain").value == 5
    assert parameters.set(DeviceUserID=42)[0].successful and camera.feature("DeviceUserID").value == "42"
    assert parameters.set(DeviceUserID=1.5)[0].successful and camera.feature("DeviceUserID").value == "1.5"


@pytest.fixture
def colour():
    """A camera with a selected feature."""
    with closing(sources.create("sim:?width=64&height=48&pixel_format=BayerRG8")) as grabber:
        grabber.open()
        yield grabber


@pytest.fixture
def of_colour(colour, domain):
    with Ros2GrabberServer(colour, "/colour"), closing(ParameterProbe("/colour")) as probe:
        yield probe


def test_a_value_under_a_selector_is_a_parameter_that_is_not_listed(of_colour, colour):
    colour.write_feature("BalanceRatioSelector", "Green")
    assert all(
        result.successful for result in of_colour.set(**{"BalanceRatio.Red": 1.5, "BalanceRatio.Blue": 2})
    )
    red, blue = of_colour.values("BalanceRatio.Red", "BalanceRatio.Blue")
    assert (red.double_value, blue.double_value) == (1.5, 2.0)
    assert (colour.read_setting(ratio("Red")).value, colour.read_setting(ratio("Blue")).value) == (1.5, 2)
    assert colour.feature("BalanceRatioSelector").value == "Green"
    (described,) = of_colour.describe("BalanceRatio.Red")
    assert described.name == "BalanceRatio.Red" and described.floating_point_range
    assert not any(name.startswith("BalanceRatio.") for name in of_colour.names())
    together = of_colour.set_together(**{"BalanceRatio.Red": 1.0, "ExposureTime": -1.0})
    assert not together.successful and colour.read_setting(ratio("Red")).value == 1.5


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("BalanceRatio.Purple", "allowed: .*Red"),
        ("BalanceRatio.Red.Left", "write BalanceRatio.<BalanceRatioSelector>"),
        ("Gain.Red", "there is no parameter Gain.Red; write Gain$"),
        ("Gian.Red", "has no feature Gian.Red"),
    ],
)
def test_a_selector_that_is_not_there_is_named(of_colour, name, reason):
    (result,) = of_colour.set(**{name: 1.0})
    assert not result.successful and re.search(reason, result.reason)


def test_an_atomic_request_sets_all_or_none(parameters, camera):
    assert parameters.set_together(Gain=2.0, ExposureTime=5000.0).successful

    result = parameters.set_together(Gain=3.0, ExposureTime=-1.0)

    assert not result.successful and "ExposureTime" in result.reason
    assert (camera.feature("Gain").value, camera.feature("ExposureTime").value) == (2.0, 5000.0)


def test_an_atomic_request_restores_the_nodes_own_parameters(parameters):
    before = parameters.values("frame_id")[0].string_value

    assert not parameters.set_together(frame_id="elsewhere", ExposureTime=-1.0).successful

    assert parameters.values("frame_id")[0].string_value == before


@pytest.mark.parametrize("name", ["a b", "a\x1b]0;t\x07", "a\nb", "a\u202eb", "é" * 128, "x" * 1_000_000])
def test_a_name_that_no_frame_has_is_refused(parameters, name):
    before = parameters.values("frame_id")[0].string_value

    result = parameters.set_together(frame_id=name)

    assert not result.successful and result.reason.isprintable() and len(result.reason) < 200
    assert "at most 255 bytes" in result.reason
    assert parameters.values("frame_id")[0].string_value == before


def test_the_longest_name_of_a_frame_is_accepted(parameters):
    before = parameters.values("frame_id")[0].string_value
    for name in ("x" * 255, "", before):
        assert parameters.set_together(frame_id=name).successful


def test_a_server_does_not_start_with_such_a_name(camera, domain):
    with pytest.raises(UsageError, match=r"parameter frame_id: .*at most 255 bytes"):
        Ros2GrabberServer(camera, "/other", frame_id="x" * 256)


def test_changes_faster_than_reads_are_read_once(domain):
    knobs = [
        Feature(name=name, kind=FeatureKind.INTEGER, access=AccessMode.READ_WRITE, value=0)
        for name in ("Knob", "Last")
    ]
    grabber = ScriptedGrabber(knobs)
    with Ros2GrabberServer(grabber, "/slow"), closing(ParameterProbe("/slow")) as parameters:
        events = parameters.subscribe(ParameterEvent, "/parameter_events", 10)

        def reported():
            grabber.set("Knob", 1 - grabber.known["Knob"].value)
            return not events.empty()

        until(reported)
        grabber.reads.clear()
        grabber.gate.clear()
        for value in range(1, 101):
            grabber.set("Knob", value)
        grabber.set("Last", 1)
        grabber.gate.set()

        seen = {}
        while "Last" not in seen:
            event = events.get(timeout=PATIENCE)
            seen |= {p.name: p.value.integer_value for p in event.changed_parameters}
        assert seen["Knob"] == 100
        assert grabber.reads.count("Knob") <= 3


def test_a_lost_camera_has_no_features(domain):
    grabber = sources.create("sim:?width=64&height=48")
    grabber.open()
    with Ros2GrabberServer(grabber, "/gone"), closing(ParameterProbe("/gone")) as parameters:
        grabber.close()

        assert "use_sim_time" in parameters.names() and "Gain" not in parameters.names()
        assert not parameters.values("Gain") and not parameters.describe("Gain")
        assert not parameters.set(Gain=1.0)[0].successful
        assert "not open" in parameters.set_together(Gain=1.0).reason


def test_changes_are_reported_as_events(server, parameters, camera):
    events = parameters.subscribe(ParameterEvent, "/parameter_events", 10)
    until(lambda: parameters.node.count_publishers("/parameter_events") >= 2)

    def reported():
        camera.write_feature("ExposureTime", 1234)
        camera.write_feature("ExposureTime", 4321)
        while not events.empty():
            event = events.get()
            values = {p.name: p.value.double_value for p in event.changed_parameters}
            if event.node == "/cam" and values.get("ExposureTime") == 4321.0:
                return True
        return False

    until(reported)


def test_only_changes_are_reported(domain):
    """A write in a camera invalidates dozens of features, most of which keep their values."""
    knobs = [
        Feature(name=name, kind=FeatureKind.FLOAT, access=AccessMode.READ_WRITE, value=value)
        for name, value in {"Knob": 1.0, "Steady": 2.0, "Unknown": math.nan, "Rounded": 3.0}.items()
    ]
    grabber = ScriptedGrabber(knobs)
    with Ros2GrabberServer(grabber, "/quiet"), closing(ParameterProbe("/quiet")) as parameters:
        events = parameters.subscribe(ParameterEvent, "/parameter_events", 10)
        until(lambda: {"Knob", "Steady", "Unknown", "Rounded"} <= set(grabber.reads))

        def reported():
            event = events.get(timeout=PATIENCE)
            while event.node != "/quiet":  # another server of the domain
                event = events.get(timeout=PATIENCE)
            return {p.name: p.value.double_value for p in event.changed_parameters}

        for value in (5.0, 6.0):
            grabber.set("Steady", 2.0)
            grabber.set("Unknown", math.nan)
            grabber.set("Knob", value)
            assert reported() == {"Knob": value}

        grabber.on_write = lambda name, value: 3.0
        assert parameters.set(Rounded=3.1)[0].successful
        assert reported() == {"Rounded": 3.0}, "whoever set 3.1 shows that"


def test_a_change_in_the_camera_is_read_immediately(parameters, camera):
    for value, watch in enumerate(attempts(1.0), 4321):
        with watch:
            camera.write_feature("ExposureTime", value)
            assert parameters.values("ExposureTime")[0].double_value == value


def test_a_file_is_loaded_on_the_running_server(parameters, camera, tmp_path):
    file = tmp_path / "camera.yaml"
    file.write_text("/cam:\n  ros__parameters:\n    GainAuto: Off\n    Gain: 3.0\n    Width: 17\n")

    results = {result.successful for result in parameters.load(file)}

    assert results == {True, False} and camera.feature("Gain").value == 3


def test_a_file_sets_several_values_of_one_selected_feature(colour, domain, tmp_path, caplog):
    file = tmp_path / "camera.yaml"
    file.write_text("/balanced:\n  ros__parameters:\n    BalanceRatio: {Red: 1.7, Blue: 2.3}\n")
    with Ros2GrabberServer(colour, "/balanced", ros_args=["--params-file", str(file)]):
        assert [colour.read_setting(ratio(entry)).value for entry in ("Red", "Blue")] == [1.7, 2.3]
    assert not caplog.records


def test_a_file_is_applied_at_the_start_with_its_qualities_of_service(camera, probe, tmp_path, caplog):
    file = tmp_path / "camera.yaml"
    file.write_text(
        "/configured:\n  ros__parameters:\n    Gain: 4.0\n    Gian: 1.0\n    Width: 17\n"
        "    qos_overrides:\n      /configured/image_raw:\n"
        "        publisher: {reliability: best_effort, depth: 3}\n"
    )
    with Ros2GrabberServer(camera, "/configured", ros_args=["--params-file", str(file)]):
        found = probe.node.get_publishers_info_by_topic
        offered = until(lambda: found("/configured/image_raw"))[0].qos_profile
        other = until(lambda: found("/configured/image"))[0].qos_profile

    assert camera.feature("Gain").value == 4
    assert (offered.reliability.name, other.reliability.name) == ("BEST_EFFORT", "RELIABLE")
    warnings = [record.message for record in caplog.records if "given at the start" in record.message]
    assert len(warnings) == 2 and "did you mean Gain" in warnings[0] and "step" in warnings[1]


def test_simulated_time_stamps_the_images(server, parameters):
    from rosgraph_msgs.msg import Clock

    clock = parameters.node.create_publisher(Clock, "/clock", 10)
    images = parameters.subscribe(Image, "/cam/image_raw")
    assert parameters.set(use_sim_time=True)[0].successful

    def stamped():
        message = Clock()
        message.clock.sec = 1000
        clock.publish(message)
        return images.get(timeout=PATIENCE).header.stamp.sec in (999, 1000)

    until(stamped)


def test_all_messages_of_a_frame_have_one_stamp_while_a_simulated_clock_runs(server, camera, parameters):
    """Subscribers match image and components by stamps, and two threads publish them at different times."""
    from rosgraph_msgs.msg import Clock

    camera.write_feature("ComponentSelector", "Range")
    camera.write_feature("ComponentEnable", True)
    clock = parameters.node.create_publisher(Clock, "/clock", 10)
    images = parameters.subscribe(Image, "/cam/image_raw")
    distances = parameters.subscribe(Image, "/cam/range/image")
    assert parameters.set(use_sim_time=True)[0].successful
    stamps = {images: set(), distances: set()}
    simulated = 1000.0

    def matched():
        nonlocal simulated
        simulated += 0.01
        message = Clock()
        message.clock.sec, message.clock.nanosec = int(simulated), int(simulated % 1 * 1e9)
        clock.publish(message)
        for topic, seen in stamps.items():
            while not topic.empty():
                stamp = topic.get().header.stamp
                if stamp.sec < 10_000:  # on the simulated clock
                    seen.add((stamp.sec, stamp.nanosec))
        return len(stamps[images] & stamps[distances]) >= 5

    until(matched)


def test_arguments_that_ros_does_not_understand_are_refused(camera, tmp_path):
    with pytest.raises(UsageError, match="--ros-args --params-file"):
        Ros2GrabberServer(camera, "/cam", ros_args=["--params-file", str(tmp_path / "missing.yaml")])
    with pytest.raises(UsageError, match=r"parameter override rule found\.$"):
        Ros2GrabberServer(camera, "/cam", ros_args=["-p"])
    with pytest.raises(UsageError, match="--ros-args --nonsense: unknown: "):
        Ros2GrabberServer(camera, "/cam", ros_args=["--nonsense"])


def test_selecting_and_setting_in_one_request_are_one_step(domain):
    """A red gain never lands in green, though somebody else moves the selector all the time."""
    camera = sources.create("sim:?width=64&height=48&pixel_format=BayerRG8")
    camera.open()
    with (
        closing(camera),
        Ros2GrabberServer(camera, "/coloured"),
        closing(ParameterProbe("/coloured")) as parameters,
        others_stay(camera),
    ):
        for number in range(15):
            value = 2 + number / 100
            assert all(r.successful for r in parameters.set(**{BALANCE: "Red", "BalanceRatio": value}))
            assert camera.read_setting(ratio("Red")).value == pytest.approx(value)
            value += 1
            assert parameters.set_together(**{BALANCE: "Red", "BalanceRatio": value}).successful
            assert camera.read_setting(ratio("Red")).value == pytest.approx(value)

"""A served camera keeps ROS's conventions: quality of service, names that move, parameters, /rosout."""

import logging
import queue
import signal
import sys
from contextlib import ExitStack
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="ROS 2 is not installed: make setup-ros2")
pytest.importorskip("grabber_interfaces", reason="the interface package is not built: make setup-ros2")
pytestmark = pytest.mark.ros2

from grabber_interfaces.srv import GetFeature  # noqa: E402
from rcl_interfaces.msg import Log  # noqa: E402
from sensor_msgs.msg import CameraInfo, CompressedImage, Image  # noqa: E402
from sensor_msgs.srv import SetCameraInfo  # noqa: E402

from fakes import ScriptedGrabber  # noqa: E402
from grabbergui import sources  # noqa: E402
from grabbergui.calibration import camera_info  # noqa: E402
from grabbergui.core.calibration import Calibration  # noqa: E402
from grabbergui.core.errors import FeatureValueError, UsageError  # noqa: E402
from grabbergui.core.features import AccessMode, Feature, FeatureKind  # noqa: E402
from grabbergui.net.ros2.client_link import publishers_of  # noqa: E402
from grabbergui.net.ros2.image_messages import path_of  # noqa: E402
from grabbergui.net.ros2.server import Ros2GrabberServer  # noqa: E402
from patience import PATIENCE  # noqa: E402
from ros2_peers import ParameterProbe, until  # noqa: E402


def test_a_plain_subscription_gets_images_and_camera_info(server, probe):
    """`create_subscription(Image, topic, callback, 10)`, as every tutorial has it, is reliable."""
    for kind, topic in (
        (Image, "image_raw"),
        (Image, "image"),
        (CameraInfo, "camera_info"),
        (CompressedImage, "image_raw/compressed"),
    ):
        assert probe.subscribe(kind, f"/cam/{topic}", 10).get(timeout=PATIENCE)


@pytest.mark.parametrize(
    "options",
    [
        {"qos": "sensor_data"},
        {"ros_args": ["-p", "qos_overrides./cam/image_raw.publisher.reliability:=best_effort"]},
    ],
)
def test_best_effort_by_option_and_by_override(serve, probe, options):
    from rclpy.qos import DurabilityPolicy, ReliabilityPolicy

    serve("/cam", **options)

    (offered,) = until(lambda: probe.node.get_publishers_info_by_topic("/cam/image_raw"))

    assert offered.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT
    assert offered.qos_profile.durability == DurabilityPolicy.VOLATILE


def test_a_frozen_reliable_reader_slows_nobody(camera):
    """The frames that the publisher drops would be those it waited for the frozen one."""
    from benchmarks._faults_ros2 import NAME, Reader

    camera.write_feature("AcquisitionFrameRate", 20)
    with ExitStack() as stack:
        server = stack.enter_context(Ros2GrabberServer(camera, NAME))
        readers = [Reader(number) for number in range(2)]
        for reader in readers:
            stack.callback(reader.close)
        reader, frozen = readers
        frozen.process.send_signal(signal.SIGSTOP)
        before, published, frames = reader.received(), server.published, camera.statistics().frames

        until(lambda: camera.statistics().frames >= frames + 60)  # many times what any queue holds

        # Half of them if it waited; a busy machine costs some, too.
        assert server.published - published >= 40
        until(lambda: reader.received() - before >= 40)
        frozen.process.send_signal(signal.SIGCONT)
        seen = frozen.received()
        until(lambda: frozen.received() > seen + 10)


@pytest.mark.parametrize(
    ("renamed", "name"),
    [
        (["-r", "__ns:=/front"], "/front/cam"),
        (["-r", "__node:=left"], "/left"),
        (["-r", "__ns:=/front", "-r", "__node:=left"], "/front/left"),
    ],
)
def test_a_renamed_node_takes_everything_along(serve, probe, renamed, name):
    server = serve("/cam", ros_args=renamed)
    assert server.name == name
    (publisher,) = until(
        lambda: [found for found in publishers_of(probe.node, f"{name}/image_raw") if found.node]
    )
    assert publisher.node == name

    def offered():
        services = dict(probe.node.get_service_names_and_types()).keys()
        topics = dict(probe.node.get_topic_names_and_types()).keys()
        wanted = {"ask", "get_feature", "set_camera_info", "set_parameters", "list_parameters"}
        return {f"{name}/{service}" for service in wanted} <= services and {
            f"{name}/{topic}" for topic in ("image", "image_raw", "image_raw/compressed", "camera_info")
        } <= topics

    until(offered)
    namespace, _, node = name.rpartition("/")
    by_node = probe.node.get_service_names_and_types_by_node
    below = until(lambda: dict(by_node(node, namespace or "/")))
    assert all(service.startswith(f"{name}/") for service in below)


@pytest.mark.parametrize(
    ("remaps", "info", "compressed"),
    [
        ({}, "/cam/camera_info", "/cam/image_raw/compressed"),
        ({"~/image_raw": "/head/left"}, "/head/camera_info", "/head/left/compressed"),
        ({"~/image_raw": "/left"}, "/camera_info", "/left/compressed"),
        ({"/cam/image_raw": "/head/left", "~/camera_info": "/calib"}, "/calib", "/head/left/compressed"),
        ({"~/image_raw": "/left", "~/image_raw/compressed": "/jpeg"}, "/camera_info", "/jpeg"),
        ({"~/image": "/left"}, "/cam/camera_info", "/cam/image_raw/compressed"),
    ],
)
def test_camera_info_and_compressed_images_follow_image_raw(serve, probe, remaps, info, compressed):
    """As image_transport places them: rviz2 and image_proc look for camera_info beside the image."""
    serve("/cam", ros_args=[word for rule in remaps.items() for word in ("-r", ":=".join(rule))])
    until(lambda: {info, compressed} <= dict(probe.node.get_topic_names_and_types()).keys())
    if remaps:
        assert probe.subscribe(CameraInfo, info, 10).get(timeout=PATIENCE)


def test_two_cameras_in_two_namespaces(serve, probe):
    """As two `PushRosNamespace` start them: the same command line twice, each below its namespace."""
    for place in ("/front", "/rear"):
        serve("/cam", ros_args=["-r", f"__ns:={place}"], frame_id=place.strip("/"))

    for place in ("/front", "/rear"):
        image = probe.subscribe(Image, f"{place}/cam/image_raw").get(timeout=PATIENCE)
        assert image.header.frame_id == place.strip("/")
        assert probe.call(GetFeature, f"{place}/cam/get_feature", name="Gain").success
        parameters = ParameterProbe(f"{place}/cam")
        assert "Gain" in parameters.names()
        parameters.close()


def test_our_client_finds_the_whole_tree_below_a_namespace(serve, camera):
    serve("/cam", ros_args=["-r", "__ns:=/front"])
    for name in ("ros2:/front/cam", "ros2:/front/cam/image_raw"):
        remote = sources.create(name)
        remote.open()
        try:
            assert remote.feature_tree() == camera.feature_tree()
        finally:
            remote.close()


def test_frame_id_is_a_parameter(serve, probe):
    serve("/cam", ros_args=["-p", "frame_id:=front_optical"])
    images = probe.subscribe(Image, "/cam/image_raw")
    assert images.get(timeout=PATIENCE).header.frame_id == "front_optical"
    parameters = ParameterProbe("/cam")
    assert parameters.values("frame_id", "camera_info_url")[0].string_value == "front_optical"

    assert parameters.set(frame_id="rear_optical")[0].successful

    until(lambda: images.get(timeout=PATIENCE).header.frame_id == "rear_optical")
    parameters.close()


def test_a_calibration_is_kept_below_ros_home_for_each_name(serve, probe, ros_home, camera):
    first = serve("/front/cam")
    calibration = Calibration.from_field_of_view(320, 240)
    info = CameraInfo(width=320, height=240, distortion_model="plumb_bob", d=[0.0] * 5)
    info.k = [float(number) for number in calibration.matrix.ravel()]

    answer = probe.call(SetCameraInfo, "/front/cam/set_camera_info", camera_info=info)

    kept = ros_home / "camera_info" / "front_cam.yaml"
    assert answer.success and str(kept) in answer.status_message and kept.is_file()
    first.stop()
    serve("/front/cam")
    infos = probe.subscribe(CameraInfo, "/front/cam/camera_info")
    until(lambda: infos.get(timeout=PATIENCE).k[0] == pytest.approx(calibration.matrix[0, 0]))


def test_camera_info_url_names_the_file_and_is_fixed(serve, probe, tmp_path):
    calibration = Calibration.from_field_of_view(320, 240)
    camera_info.save(calibration, tmp_path / "a camera.yaml")
    serve("/cam", ros_args=["-p", f"camera_info_url:=file://{tmp_path}/a%20camera.yaml"])

    infos = probe.subscribe(CameraInfo, "/cam/camera_info")

    assert infos.get(timeout=PATIENCE).k[0] == pytest.approx(calibration.matrix[0, 0])
    parameters = ParameterProbe("/cam")
    (refused,) = parameters.set(camera_info_url="file:///etc/passwd")
    assert not refused.successful and "read-only" in refused.reason
    parameters.close()


def test_a_file_below_ros_home_that_holds_none_is_no_reason_to_stop(serve, ros_home, caplog):
    (ros_home / "camera_info").mkdir(parents=True)
    (ros_home / "camera_info" / "cam.yaml").write_text("nonsense")

    serve("/cam")

    assert [record for record in caplog.records if "without this calibration" in record.message]


@pytest.mark.parametrize(
    ("url", "path"),
    [
        ("", "/ros/camera_info/front_cam.yaml"),
        ("file:///calibrations/a%20b.yaml", "/calibrations/a b.yaml"),
        ("file:///calibrations/${NAME}.yaml", "/calibrations/front_cam.yaml"),
        ("file://${ROS_HOME}/mine.yaml", "/ros/mine.yaml"),
    ],
)
def test_a_calibration_url_is_resolved_as_camera_info_manager_does(url, path, monkeypatch):
    monkeypatch.setenv("ROS_HOME", "/ros")
    assert str(path_of(url, "/front/cam")) == path


def test_the_default_place_of_a_user_that_the_system_does_not_know(monkeypatch):
    """As in a container that runs under any number."""

    def unknown():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("ROS_HOME", raising=False)
    monkeypatch.setattr(Path, "home", unknown)
    assert path_of("", "/cam") == Path("/.ros/camera_info/cam.yaml")


def test_a_url_in_a_package(monkeypatch):
    monkeypatch.setenv("AMENT_PREFIX_PATH", sys.prefix, prepend=":")
    assert path_of("package://sensor_msgs/cam.yaml", "/cam").parent.name == "sensor_msgs"


@pytest.mark.parametrize(
    "url", ["file://cam.yaml", "http://host/cam.yaml", "cam.yaml", "package://nobody/cam.yaml"]
)
def test_urls_that_mean_no_file(url):
    with pytest.raises(UsageError, match="camera_info_url"):
        path_of(url, "/cam")


def test_a_parameter_of_another_type_is_named(camera):
    with pytest.raises(UsageError, match="frame_id"):
        Ros2GrabberServer(camera, "/cam", ros_args=["-p", "frame_id:=3"])


def test_a_read_only_server_refuses_a_new_frame_id(serve):
    serve("/cam", read_only=True)
    parameters = ParameterProbe("/cam")
    assert not parameters.set(frame_id="elsewhere")[0].successful
    parameters.close()


def test_an_event_for_a_subscription_that_another_thread_ended_is_no_failure(domain, caplog):
    from rclpy.exceptions import InvalidHandle

    from grabbergui.net.ros2.runtime import Ros2Node

    ros, calls = Ros2Node("busy"), queue.Queue()

    def ended():
        calls.put(None)
        raise InvalidHandle("cannot use Destroyable because destruction was requested")

    ros.node.create_timer(0.01, ended)
    ros.start()
    for _ in range(3):
        calls.get(timeout=PATIENCE)
    ros.close()
    assert not caplog.records


def test_text_that_is_no_utf_8_is_answered_and_others_follow(domain):
    name = Feature(name="Name", kind=FeatureKind.STRING, access=AccessMode.READ_WRITE, value="caf\udce9")
    camera = ScriptedGrabber([name])
    with Ros2GrabberServer(camera, "/front/latin"):
        parameters = ParameterProbe("/front/latin")
        assert parameters.values("Name")[0].string_value == "caf?"
        camera.refusals["Name"] = FeatureValueError("Name: caf\udce9 stays", "Name")
        assert parameters.set(Name="other")[0].reason == "Name: caf? stays"
        parameters.close()


def test_rosout_carries_warnings_and_errors(domain, probe):
    from rclpy.qos import DurabilityPolicy, QoSProfile

    with Ros2GrabberServer(ScriptedGrabber(), "/front/noisy"):
        log = logging.getLogger("grabbergui.driver.device_grabber")
        log.warning("frames are being %s", "lost")
        log.warning("%s cannot be read", "caf\udce9.yaml")  # as a file name in Latin-1 is
        log.error("the camera is gone")
        log.info("nothing of interest")
        quality = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        messages = probe.subscribe(Log, "/rosout", quality)
        ours = queue.SimpleQueue()

        def heard():
            message = messages.get(timeout=PATIENCE)
            if message.name == "front.noisy":
                ours.put((message.level, message.msg))
            return ours.qsize() == 3

        until(heard)
    assert [ours.get() for _ in range(3)] == [
        (30, "frames are being lost"),
        (30, "caf?.yaml cannot be read"),
        (40, "the camera is gone"),
    ]
    assert not [handler for handler in logging.getLogger("grabbergui").handlers if "Rosout" in repr(handler)]

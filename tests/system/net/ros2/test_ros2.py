"""With real rclpy: our server seen by an independent node, our client, and somebody else's driver."""

import ast
import queue
import subprocess
import sys
import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest

from grabbergui.core.errors import UsageError

pytest.importorskip("rclpy", reason="ROS 2 is not installed: make setup-ros2")
pytest.importorskip("grabber_interfaces", reason="the interface package is not built: make setup-ros2")
pytestmark = pytest.mark.ros2

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus  # noqa: E402
from rcl_interfaces.msg import ParameterEvent  # noqa: E402
from sensor_msgs.msg import CameraInfo, CompressedImage, Image, PointCloud2, PointField  # noqa: E402
from sensor_msgs.srv import SetCameraInfo  # noqa: E402

from fakes import ScriptedGrabber  # noqa: E402
from grabbergui import sources  # noqa: E402
from grabbergui.calibration.fitting import FittedCalibration  # noqa: E402
from grabbergui.core.camera_info_message import read_camera_info  # noqa: E402
from grabbergui.core.frame_queue import StreamStatistics  # noqa: E402
from grabbergui.net.ros2.client_link import IMAGE_TYPE  # noqa: E402
from grabbergui.net.ros2.image_messages import receive_camera_info  # noqa: E402
from grabbergui.net.ros2.runtime import quality_of_service  # noqa: E402
from grabbergui.net.ros2.server import Ros2GrabberServer  # noqa: E402
from lost_camera import away  # noqa: E402
from patience import PATIENCE  # noqa: E402
from ros2_peers import ParameterProbe, until  # noqa: E402


def test_images_and_camera_info_at_the_cameras_rate(server, probe):
    begun = time.time()
    images, infos = probe.subscribe(Image, "/cam/image_raw"), probe.subscribe(CameraInfo, "/cam/camera_info")
    images.get(timeout=PATIENCE)
    infos.get(timeout=PATIENCE)

    def steady():
        """Images at the camera's rate; others who have the cores may make it stumble now and then."""
        some = [images.get(timeout=PATIENCE) for _ in range(50)]
        first, last = (m.header.stamp.sec + m.header.stamp.nanosec / 1e9 for m in (some[0], some[-1]))
        return some if (last - first) / 49 == pytest.approx(1 / 50, rel=0.1) else None

    message = until(steady)[-1]
    assert (message.encoding, message.width, message.height, message.step) == ("bayer_rggb8", 320, 240, 320)
    assert len(message.data) == 320 * 240 and message.header.frame_id == "camera"
    assert begun - 3 < message.header.stamp.sec <= time.time()
    assert infos.get(timeout=PATIENCE).width == 320


def test_nothing_is_published_while_nobody_listens(server, camera):
    queue = camera.open_queue(30)
    for _ in range(10):
        queue.get(PATIENCE)

    assert server.published == 0


def test_changes_are_not_read_for_parameter_events_while_nobody_listens(server, probe, camera, monkeypatch):
    read = queue.Queue()

    def feature(name, of_camera=camera.feature):
        if threading.current_thread().name == "ros2 parameter events":
            read.put(name)
        return of_camera(name)

    def change():
        camera.write_feature("ExposureTime", 4000 + time.monotonic() % 100)

    monkeypatch.setattr(camera, "feature", feature)
    change()
    with pytest.raises(queue.Empty):
        read.get(timeout=0.5)

    probe.subscribe(ParameterEvent, "/parameter_events", 10)
    until(lambda: change() or not read.empty())


def test_an_incompatible_qos_request_is_logged(serve, probe, caplog):
    serve("/cam", qos="sensor_data")
    probe.subscribe(Image, "/cam/image", quality_of_service("reliable"))

    until(lambda: [record for record in caplog.records if "with --qos reliable" in record.message])


def test_a_subscriber_to_kept_messages_is_not_sent_to_an_option_that_does_not_help(serve, probe, caplog):
    from rclpy.qos import DurabilityPolicy, QoSProfile

    serve("/cam")
    kept = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    probe.subscribe(Image, "/cam/image", kept)

    until(lambda: [record for record in caplog.records if "images are volatile" in record.message])
    assert not any("--qos" in record.message for record in caplog.records)


def test_compressed_images_can_be_read(server, probe):
    import cv2

    message = probe.subscribe(CompressedImage, "/cam/image_raw/compressed").get(timeout=PATIENCE)

    assert message.format == "bgr8; jpeg compressed bgr8"
    assert cv2.imdecode(np.frombuffer(message.data, np.uint8), cv2.IMREAD_COLOR).shape == (240, 320, 3)


def test_the_quality_of_jpeg_is_a_parameter(serve, probe):
    from rcl_interfaces.srv import SetParameters
    from rclpy.parameter import Parameter

    serve("/cam", ros_args=["-p", "image_raw.compressed.jpeg_quality:=95"])
    images = probe.subscribe(CompressedImage, "/cam/image_raw/compressed")
    fine = len(images.get(timeout=PATIENCE).data)

    def set_quality(value):
        parameter = Parameter("image_raw.compressed.jpeg_quality", value=value).to_parameter_msg()
        (result,) = probe.call(SetParameters, "/cam/set_parameters", parameters=[parameter]).results
        return result.successful

    assert not set_quality(101) and set_quality(20)
    until(lambda: len(images.get(timeout=PATIENCE).data) < fine / 2)


def test_compressed_images_may_be_png_and_distances_compressed_depth(serve, probe, camera):
    """With image_transport's parameters."""
    from grabbergui.net.ros2.compressed_images import frame_of_compressed

    camera.write_feature("PixelFormat", "Mono12")
    serve("/cam", ros_args=["-p", "image_raw.compressed.format:=png"])
    images = probe.subscribe(CompressedImage, "/cam/image_raw/compressed")
    message = images.get(timeout=PATIENCE)
    assert message.format == "mono16; png compressed mono16"
    assert frame_of_compressed(message, 1).raw().max() > 255

    parameters = ParameterProbe("/cam")
    (refused,) = parameters.set(**{"image_raw.compressed.format": "gif"})
    assert not refused.successful and "jpeg or png" in refused.reason
    assert parameters.set(**{"image_raw.compressed.format": "jpeg"})[0].successful
    until(lambda: images.get(timeout=PATIENCE).format == "mono8; jpeg compressed mono8")
    parameters.close()

    camera.write_feature("ComponentSelector", "Range")
    camera.write_feature("ComponentEnable", True)
    message = probe.subscribe(CompressedImage, "/cam/range/image/compressedDepth").get(timeout=PATIENCE)
    assert message.format == "32FC1; compressedDepth png"
    metres = frame_of_compressed(message, 1).raw()
    assert metres.shape == (240, 320) and 0.5 < np.nanmin(metres) < np.nanmax(metres) < 1.5


def test_camera_info_is_kept_for_late_subscribers(serve, probe, camera):
    """As when the camera waits for a trigger, and sends no images."""
    from rclpy.qos import DurabilityPolicy, QoSProfile

    server = serve("/cam")
    until(lambda: server._images._info_sent)
    camera.stop()
    late = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    message = probe.subscribe(CameraInfo, "/cam/camera_info", late).get(timeout=PATIENCE)
    assert (message.width, message.height) == (320, 240)


@pytest.mark.parametrize("value", ["0", "high"])
def test_a_quality_of_jpeg_that_does_not_exist_is_refused(camera, domain, value):
    with pytest.raises(UsageError, match="jpeg_quality"):
        Ros2GrabberServer(camera, "/cam", ros_args=["-p", f"image_raw.compressed.jpeg_quality:={value}"])


def whole_sensor():
    """Return a calibration of the simulated camera's whole sensor."""
    info = CameraInfo(width=4096, height=2160, distortion_model="plumb_bob", d=[0.1, 0.0, 0.0, 0.0, 0.0])
    info.k = [1500.0, 0.0, 2047.5, 0.0, 1500.0, 1079.5, 0.0, 0.0, 1.0]
    return info


def test_a_calibration_is_kept_and_scaled(server, probe, camera, tmp_path):
    assert probe.call(SetCameraInfo, "/cam/set_camera_info", camera_info=whole_sensor()).success
    assert not probe.call(SetCameraInfo, "/cam/set_camera_info", camera_info=CameraInfo()).success

    infos = probe.subscribe(CameraInfo, "/cam/camera_info")
    until(lambda: infos.get(timeout=PATIENCE).k[0] == 1500)
    camera.write_feature("BinningHorizontal", 2)
    camera.write_feature("BinningVertical", 2)
    message = until(lambda: (found := infos.get(timeout=PATIENCE)).binning_y == 2 and found)
    assert (message.width, message.height, message.k[0]) == (4096, 2160, 1500)
    assert read_camera_info(message, "cam").matrix[0, 0] == 750
    assert "cam" in (tmp_path / "cam.yaml").read_text()


def test_a_calibration_outlives_the_server(camera, probe, tmp_path):
    file = tmp_path / "cam.yaml"
    with Ros2GrabberServer(camera, "/cam", calibration=FittedCalibration(camera, file)):
        answer = probe.call(SetCameraInfo, "/cam/set_camera_info", camera_info=whole_sensor())
        assert answer.success and str(file) in answer.status_message

    with Ros2GrabberServer(camera, "/again", calibration=FittedCalibration(camera, file)):
        infos = probe.subscribe(CameraInfo, "/again/camera_info")
        message = infos.get(timeout=PATIENCE)

    offset = camera.feature("OffsetX").value
    assert (message.k[0], message.k[2], message.d[0]) == (1500.0, 2047.5, 0.1)
    assert (message.roi.x_offset, message.roi.width, message.roi.height) == (offset, 320, 240)


def test_an_impossible_calibration_is_refused_and_a_refused_file_stops_no_server(camera, probe, tmp_path):
    file = tmp_path / "cam.yaml"
    huge, overflowing = whole_sensor(), whole_sensor()
    huge.width, overflowing.d = 4_000_000_000, [1e308, 0.0, 0.0, 0.0, 0.0]
    with Ros2GrabberServer(camera, "/cam", calibration=FittedCalibration(camera, file)):
        for message, said in ((huge, "a side has"), (overflowing, "1e+308")):
            answer = probe.call(SetCameraInfo, "/cam/set_camera_info", camera_info=message)
            assert not answer.success and said in answer.status_message
    assert not file.exists()

    file.write_text("image_width: 4000000000\n")  # as version 0.2 kept it
    with Ros2GrabberServer(camera, "/again", calibration=FittedCalibration(camera, file)):
        assert probe.subscribe(CameraInfo, "/again/camera_info").get(timeout=PATIENCE).k[0] == 0
        answer = probe.call(SetCameraInfo, "/again/set_camera_info", camera_info=whole_sensor())
        assert not answer.success and "rename or remove it" in answer.status_message


def test_a_calibration_that_cannot_be_kept_is_refused(camera, probe, tmp_path):
    calibration = FittedCalibration(camera, tmp_path / "missing" / "cam.yaml")
    with Ros2GrabberServer(camera, "/cam", calibration=calibration):
        answer = probe.call(SetCameraInfo, "/cam/set_camera_info", camera_info=whole_sensor())

    assert not answer.success and "missing" in answer.status_message


def test_diagnostics_tell_rate_losses_and_temperature(serve, probe, camera):
    serve("/diagnosed")  # a name that discovery cannot remember from a test before
    arrays = probe.subscribe(DiagnosticArray, "/diagnostics")

    def facts_of(status):
        return {value.key: value.value for value in status.values}

    def healthy():
        """Others who have the cores make the simulated camera stumble, and catch up."""
        (status,) = arrays.get(timeout=PATIENCE).status
        usual = float(facts_of(status)["frame_rate"]) == pytest.approx(50, rel=0.2)
        ours = status.name.startswith("diagnosed: ")
        return status if ours and usual and status.level == DiagnosticStatus.OK else None

    status = until(healthy)

    facts = facts_of(status)
    assert status.name == f"diagnosed: {camera.info.title}" and "frames/s" in status.message
    assert {"lost", "incomplete", "packets_missing", "published", "dropped"} <= facts.keys()
    assert float(facts["temperature"]) == pytest.approx(camera.feature("DeviceTemperature").value, abs=5)


def test_diagnostics_say_what_is_being_lost_and_when_it_is_over(domain, probe):
    grabber = ScriptedGrabber()
    counters = StreamStatistics(frames=10, lost=3, frame_rate=9.5)
    grabber.statistics = lambda: counters
    with Ros2GrabberServer(grabber, "/lossy"):
        arrays = probe.subscribe(DiagnosticArray, "/diagnostics")

        def says(message):
            (status,) = arrays.get(timeout=PATIENCE).status
            return status if status.message == message else None

        until(lambda: says("9.5 frames/s"))
        counters.lost += 2
        lossy = until(lambda: says("9.5 frames/s, 2 lost in the last second"))
        until(lambda: says("9.5 frames/s"))
        counters.frame_rate = 0.0
        silent = until(lambda: says("no frames"))

    assert (lossy.level, silent.level) == (DiagnosticStatus.WARN, DiagnosticStatus.ERROR)


def test_diagnostics_say_that_the_camera_is_lost(camera, serve, probe):
    serve("/cam")
    arrays = probe.subscribe(DiagnosticArray, "/diagnostics")
    with away(camera, "the cable is out"):
        lost = (DiagnosticStatus.ERROR, "the camera is lost: the cable is out")
        # A report that was made between the last frame and the loss says that there are no frames.
        until(
            lambda: (
                (status := arrays.get(timeout=PATIENCE).status[0]) and (status.level, status.message) == lost
            )
        )
    until(lambda: arrays.get(timeout=PATIENCE).status[0].level == DiagnosticStatus.OK)


def test_diagnostics_go_on_while_a_simulated_clock_stands(serve, probe):
    serve("/cam", ros_args=["-p", "use_sim_time:=true"])
    arrays = probe.subscribe(DiagnosticArray, "/diagnostics")
    for _ in range(2):
        assert arrays.get(timeout=PATIENCE).header.stamp.sec == 0


def test_another_node_of_the_same_name_is_reported(server, camera, serve, probe, caplog):
    arrays = probe.subscribe(DiagnosticArray, "/diagnostics")
    until(lambda: arrays.get(timeout=PATIENCE).status[0].level == DiagnosticStatus.OK)
    assert "another node" not in caplog.text
    namesake = serve("/cam")
    until(lambda: "another node is called /cam" in caplog.text)
    until(lambda: "another node has this name" in arrays.get(timeout=PATIENCE).status[0].message)
    namesake.stop()
    until(lambda: arrays.get(timeout=PATIENCE).status[0].level == DiagnosticStatus.OK)


def test_diagnostics_go_on_when_the_camera_is_closed_first(camera, serve, probe, caplog):
    serve("/cam")
    arrays = probe.subscribe(DiagnosticArray, "/diagnostics")
    camera.close()

    until(lambda: "temperature" not in {value.key for value in arrays.get(timeout=PATIENCE).status[0].values})

    assert not [record for record in caplog.records if "callback failed" in record.message]


def test_a_region_leaves_images_and_calibration_right(server, probe, camera):
    assert probe.call(SetCameraInfo, "/cam/set_camera_info", camera_info=whole_sensor()).success
    images, infos = probe.subscribe(Image, "/cam/image_raw"), probe.subscribe(CameraInfo, "/cam/camera_info")
    before = camera.feature("OffsetX").value
    until(lambda: infos.get(timeout=PATIENCE).roi.x_offset == before)

    camera.write_feature("Height", 200)  # other proportions than the calibration's
    camera.write_feature("OffsetX", 64)

    message = until(lambda: (found := infos.get(timeout=PATIENCE)).roi.x_offset == 64 and found)
    assert (message.roi.width, message.roi.height) == (320, 200)
    assert read_camera_info(message, "cam").matrix[0, 2] == 2047.5 - 64
    until(lambda: images.get(timeout=PATIENCE).height == 200)


def as_image_geometry(message):
    """Return fx, fy, cx, cy of K and of P for the image, as image_geometry computes them."""
    found = []
    for matrix, columns in ((message.k, 3), (message.p, 4)):
        fx, cx, fy, cy = matrix[0], matrix[2], matrix[columns + 1], matrix[columns + 2]
        cx, cy = cx - message.roi.x_offset, cy - message.roi.y_offset
        across, down = max(message.binning_x, 1), max(message.binning_y, 1)
        found.append((fx / across, fy / down, cx / across, cy / down))
    return found


def test_a_calibrated_region_stays_right_when_the_camera_bins_and_the_region_moves(
    server, probe, camera, remote
):
    """The image has the same size throughout, so its size shows no change."""
    info = CameraInfo(width=320, height=240, distortion_model="plumb_bob", d=[0.1, 0.0, 0.0, 0.0, 0.0])
    info.k = [500.0, 0.0, 160.0, 0.0, 500.0, 120.0, 0.0, 0.0, 1.0]
    assert probe.call(SetCameraInfo, "/cam/set_camera_info", camera_info=info).success
    infos = probe.subscribe(CameraInfo, "/cam/camera_info")
    same = until(lambda: (found := infos.get(timeout=PATIENCE)).k[0] and found)
    assert list(same.k) == list(info.k) and (same.roi.width, same.binning_x) == (0, 0)
    calibrated = [camera.feature(name).value for name in ("OffsetX", "OffsetY")]

    for name in ("BinningHorizontal", "BinningVertical"):
        camera.write_feature(name, 2)
    camera.write_feature("OffsetX", 64)
    camera.write_feature("OffsetY", 32)

    message = until(lambda: (found := infos.get(timeout=PATIENCE)).roi.y_offset == 64 and found)
    assert (message.width, message.height, message.binning_x, message.binning_y) == (4096, 2160, 2, 2)
    assert (message.roi.x_offset, message.roi.width, message.roi.height) == (128, 640, 480)
    # The centre of a pixel that combines 2×2 lies half a pixel of the sensor from that of its first.
    centre = [(160 + calibrated[0] - 0.5) / 2 - 64, (120 + calibrated[1] - 0.5) / 2 - 32]
    for model in as_image_geometry(message):  # which leaves out this half pixel
        assert model == pytest.approx((250, 250, centre[0] + 0.25, centre[1] + 0.25))
    matrix = read_camera_info(message, "cam").matrix
    assert (matrix[0, 0], *matrix[:2, 2]) == pytest.approx((250, *centre))

    remote.start()
    seen = until(lambda: (found := remote.calibration()) and found.matrix[0, 0] == 250 and found)
    assert (seen.width, seen.height) == (320, 240) and np.allclose(seen.matrix, matrix)


def test_image_topics_are_listed(server):
    from grabbergui.net.ros2 import client

    until(lambda: "ros2:/cam" in [info.uri for info in client.discover(1.0)])


def test_a_search_goes_on_when_one_camera_is_found(monkeypatch):
    """DDS discovers one publisher at once and another when its announcement is repeated."""
    from grabbergui.net.ros2 import client

    began = time.monotonic()

    class Node:
        def get_topic_names_and_types(self):
            late = time.monotonic() > began + 0.3
            return [(f"/{name}/image_raw", [IMAGE_TYPE]) for name in (("near", "far") if late else ("near",))]

        def get_publishers_info_by_topic(self, _topic):
            return []

    monkeypatch.setattr(client, "_listener", lambda *_: (SimpleNamespace(node=Node()), began))
    assert sorted(info.uri for info in client.discover(0.5)) == ["ros2:/far", "ros2:/near"]


def test_each_domain_has_a_discovery_node_of_its_own(server, monkeypatch):
    from grabbergui.net.ros2 import client

    until(lambda: client.discover(1.0))
    monkeypatch.setenv("ROS_DOMAIN_ID", "101")
    assert client.discover(0.3) == []


@pytest.mark.parametrize(
    "name", ["/left camera", "/left-camera", "/1st", "/left//camera", "/cámara", "/\udce9"]
)
def test_a_bad_name_is_refused(camera, name):
    for use in (
        lambda: Ros2GrabberServer(camera, name),
        lambda: sources.create(f"ros2:{name}"),
        lambda: receive_camera_info(f"{name}?qos=reliable"),
    ):
        with pytest.raises(UsageError, match="names on ROS 2 are of letters"):
            use()


def test_components_are_topics_with_ranges_in_metres_and_points_on_request(server, camera, probe):
    for name in ("Range", "Confidence"):
        camera.write_feature("ComponentSelector", name)
        camera.write_feature("ComponentEnable", True)
    distances = probe.subscribe(Image, "/cam/range/image")
    clouds = probe.subscribe(PointCloud2, "/cam/range/points")
    confidences = probe.subscribe(Image, "/cam/confidence/image")
    info = probe.subscribe(CameraInfo, "/cam/range/camera_info")
    assert probe.call(SetCameraInfo, "/cam/set_camera_info", camera_info=whole_sensor()).success

    message = distances.get(timeout=PATIENCE)
    assert (message.encoding, message.width, message.height, message.step) == ("32FC1", 320, 240, 1280)
    assert message.header.frame_id == "camera" and abs(time.time() - message.header.stamp.sec) < 60
    metres = np.frombuffer(message.data, "<f4")
    assert np.isnan(metres).any() and 0.55 < np.nanmin(metres) < np.nanmax(metres) < 1.5

    fitted = until(lambda: (found := info.get(timeout=PATIENCE)).k[0] and found)
    assert (fitted.roi.width, fitted.roi.height, fitted.k[0]) == (320, 240, 1500.0)

    confidence = confidences.get(timeout=PATIENCE)
    assert (confidence.encoding, len(confidence.data)) == ("mono8", 320 * 240)

    # Now and then the simulated scene has no pixel without a measurement.
    cloud = until(lambda: (found := clouds.get(timeout=PATIENCE)).width < 320 * 240 and found)
    assert [(field.name, field.offset, field.datatype) for field in cloud.fields] == [
        ("x", 0, PointField.FLOAT32),
        ("y", 4, PointField.FLOAT32),
        ("z", 8, PointField.FLOAT32),
        ("rgb", 12, PointField.FLOAT32),
    ]
    layout = {"names": ["x", "y", "z"], "formats": ["<f4"] * 3, "itemsize": cloud.point_step}
    points = np.frombuffer(cloud.data, layout)
    assert cloud.width == len(points) > 0
    assert 0.55 < points["z"].min() < points["z"].max() < 1.5
    scale = points["x"] / points["z"] * 2000  # columns from the principal point, by the focal length
    assert np.abs(scale - np.rint(scale)).max() < 1e-2
    assert np.ptp(scale) == pytest.approx(319, abs=1)


def test_what_is_prepared_is_not_loaded_at_the_click(camera, domain):
    """The modules of a node took half of the time until its first image."""
    code = (
        "import sys\n"
        "from grabbergui.net.ros2.preparation import prepare\n"
        "prepare()\n"
        "from grabbergui import sources\n"
        "from grabbergui.net.ros2.server import Ros2GrabberServer\n"
        "camera = sources.create('sim:?width=64&height=48')\n"
        "camera.open()\n"
        "before = set(sys.modules)\n"
        "with Ros2GrabberServer(camera, '/prepared'):\n"
        "    late = {name.partition('.')[0] for name in set(sys.modules) - before}\n"
        "camera.close()\n"
        "print(sorted(late))\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    late = set(ast.literal_eval(done.stdout.splitlines()[-1]))
    # rclpy imports the last only as it makes a node.
    assert late <= {"grabbergui", "type_description_interfaces"}

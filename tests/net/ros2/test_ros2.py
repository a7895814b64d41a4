"""With real rclpy: our server seen by an independent node, our client, and somebody else's driver."""

import queue as queue_module
import time

import numpy as np
import pytest

from grabbergui import sources
from grabbergui.core.errors import FeatureNotFoundError, FeatureValueError, SourceNotFoundError, UsageError
from grabbergui.core.grabber import ConnectionState

pytest.importorskip("rclpy", reason="ROS 2 is not installed: make setup-ros2")
pytest.importorskip("grabber_interfaces", reason="the interface package is not built: make setup-ros2")
pytestmark = pytest.mark.ros2

from rclpy.parameter import Parameter  # noqa: E402
from ros2_peers import until  # noqa: E402
from sensor_msgs.msg import CameraInfo, CompressedImage, Image  # noqa: E402
from sensor_msgs.srv import SetCameraInfo  # noqa: E402

from grabbergui.net.ros2.runtime import Ros2Node  # noqa: E402
from grabbergui.net.ros2.server import Ros2GrabberServer  # noqa: E402


def test_images_and_camera_info_at_the_cameras_rate(server, probe):
    images, infos = probe.subscribe(Image, "/cam/image_raw"), probe.subscribe(CameraInfo, "/cam/camera_info")
    images.get(timeout=10)
    infos.get(timeout=10)

    some = [images.get(timeout=5) for _ in range(50)]

    message = some[-1]
    assert (message.encoding, message.width, message.height, message.step) == ("bayer_rggb8", 320, 240, 320)
    assert len(message.data) == 320 * 240 and message.header.frame_id == "camera"
    stamps = [m.header.stamp.sec + m.header.stamp.nanosec / 1e9 for m in some]
    assert (stamps[-1] - stamps[0]) / 49 == pytest.approx(1 / 50, rel=0.1)
    assert abs(time.time() - stamps[-1]) < 2
    assert infos.get(timeout=5).width == 320


def test_nothing_is_published_while_nobody_listens(server, camera):
    queue = camera.open_queue(30)
    for _ in range(10):
        queue.get(5)

    assert server.published == 0


def test_compressed_pictures_can_be_read(server, probe):
    import cv2

    message = probe.subscribe(CompressedImage, "/cam/image_raw/compressed").get(timeout=10)

    assert message.format == "bayer_rggb8; jpeg compressed bgr8"
    assert cv2.imdecode(np.frombuffer(message.data, np.uint8), cv2.IMREAD_COLOR).shape == (240, 320, 3)


def whole_sensor():
    """What a calibration of the simulated camera's whole sensor says."""
    info = CameraInfo(width=4096, height=2160, distortion_model="plumb_bob", d=[0.1, 0.0, 0.0, 0.0, 0.0])
    info.k = [1500.0, 0.0, 2047.5, 0.0, 1500.0, 1079.5, 0.0, 0.0, 1.0]
    return info


def test_a_calibration_is_kept_and_scaled(server, probe, camera, tmp_path):
    assert probe.call(SetCameraInfo, "/cam/set_camera_info", camera_info=whole_sensor()).success
    assert not probe.call(SetCameraInfo, "/cam/set_camera_info", camera_info=CameraInfo()).success

    infos = probe.subscribe(CameraInfo, "/cam/camera_info")
    until(lambda: infos.get(timeout=5).k[0] == 1500)
    camera.write_feature("BinningHorizontal", 2)
    camera.write_feature("BinningVertical", 2)
    until(lambda: infos.get(timeout=5).k[0] == 750)
    assert "cam" in (tmp_path / "cam.yaml").read_text()


def test_a_region_leaves_pictures_and_calibration_right(server, probe, camera):
    assert probe.call(SetCameraInfo, "/cam/set_camera_info", camera_info=whole_sensor()).success
    images, infos = probe.subscribe(Image, "/cam/image_raw"), probe.subscribe(CameraInfo, "/cam/camera_info")
    before = camera.feature("OffsetX").value
    until(lambda: infos.get(timeout=5).k[2] == 2047.5 - before)

    camera.write_feature("Height", 200)  # other proportions than the calibration's
    camera.write_feature("OffsetX", 64)

    until(lambda: infos.get(timeout=5).k[2] == 2047.5 - 64)
    until(lambda: images.get(timeout=5).height == 200)


def test_our_client_has_the_whole_tree_and_the_pictures(remote, camera):
    assert remote.feature_tree() == camera.feature_tree()
    assert remote.info.model == "Simulated camera"
    queue = remote.open_queue()
    remote.start()
    frame = queue.get(10)
    assert (frame.pixel_format.name, frame.rgb().shape) == ("BayerRG8", (240, 320, 3))
    assert remote.write_feature("Gain", 3).value == 3 and camera.feature("Gain").value == 3
    with pytest.raises(FeatureValueError, match="allowed is 0 … 24 dB"):
        remote.write_feature("Gain", 100)
    with pytest.raises(FeatureNotFoundError, match="did you mean Gain"):
        remote.feature("Gian")
    remote.execute("TimestampLatch")


def test_others_changes_are_told(remote, camera):
    told = queue_module.Queue()
    remote.features_changed.connect(told.put)
    time.sleep(0.5)  # the first look only finds out where the numbering stands

    camera.write_feature("Gain", 2)

    until(lambda: "Gain" in told.get(timeout=5))


def test_a_server_that_vanishes_and_comes_back(camera):
    states = queue_module.Queue()
    server = Ros2GrabberServer(camera, "/cam")
    server.start()
    remote = sources.create("ros2:/cam")
    remote.open()
    remote.connection_changed.connect(lambda state, why: states.put(state))

    server.stop()
    assert states.get(timeout=15) is ConnectionState.LOST
    with Ros2GrabberServer(camera, "/cam"):
        assert states.get(timeout=15) is ConnectionState.OPEN
    remote.close()


def test_somebody_elses_driver_by_its_parameters(probe):
    from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor

    driver = Ros2Node("driver")
    span = FloatingPointRange(from_value=1.0, to_value=9.0, step=0.0)
    descriptor = ParameterDescriptor(description="how bright", floating_point_range=[span])
    driver.node.declare_parameter("exposure", 2.0, descriptor)
    images = driver.node.create_publisher(Image, "/other/image_raw", 10)
    message = Image(width=4, height=2, encoding="mono8", step=8, data=bytes(range(16)))
    driver.node.create_timer(0.02, lambda: images.publish(message))
    driver.start()

    remote = sources.create("ros2:/other")
    remote.open()
    exposure = remote.feature("exposure")
    assert (exposure.value, exposure.minimum, exposure.maximum, exposure.tooltip) == (
        2.0,
        1.0,
        9.0,
        "how bright",
    )
    assert remote.write_feature("exposure", "4.5").value == 4.5
    with pytest.raises(FeatureValueError, match="allowed is 1 … 9"):
        remote.write_feature("exposure", 10)
    told = queue_module.Queue()
    remote.features_changed.connect(told.put)
    driver.node.set_parameters([Parameter("exposure", value=3.0)])
    assert told.get(timeout=5) == frozenset({"exposure"}) and remote.feature("exposure").value == 3.0
    queue = remote.open_queue()
    remote.start()
    assert queue.get(10).raw().tolist() == [[0, 1, 2, 3], [8, 9, 10, 11]]
    remote.close()
    driver.close()


def test_image_topics_are_listed(server):
    from grabbergui.net.ros2 import source

    until(lambda: "ros2:/cam" in [info.uri for info in source.discover(1.0)])


def test_a_topic_that_is_not_there():
    with pytest.raises(SourceNotFoundError, match="nobody publishes images at /nowhere/image_raw"):
        sources.create("ros2:/nowhere").open()
    with pytest.raises(UsageError, match="which topic"):
        sources.create("ros2:")


def test_a_bad_name_is_refused(camera):
    with pytest.raises(UsageError, match="names are of letters"):
        Ros2GrabberServer(camera, "/left camera")

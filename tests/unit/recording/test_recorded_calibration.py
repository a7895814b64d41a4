"""Recordings of ROS messages have the calibration of each frame, and may be a folder of rosbag2."""

import numpy as np
import pytest

from grabbergui import sources
from grabbergui.calibration import camera_info
from grabbergui.cli import main
from grabbergui.core.calibration import Calibration, FrameCalibration
from grabbergui.core.camera_info_message import CameraInfoFields, fill_camera_info, read_camera_info
from grabbergui.core.errors import UsageError
from grabbergui.recording.kinds import RecordingKind, kind_of
from grabbergui.recording.opening import open_recording
from patience import until

SIM = "sim:?width=64&height=48&fps=100"
MATRIX = np.array([[500.0, 0, 31.5], [0, 510.0, 23.5], [0, 0, 1]])
LENS = np.array([-0.2, 0.1, 0.01, 0.02, 0.3])


@pytest.fixture
def calibration(tmp_path):
    camera_info.save(Calibration(64, 48, MATRIX, LENS), tmp_path / "camera.yaml")
    return str(tmp_path / "camera.yaml")


def recorded(out, *options):
    assert main(["record", SIM, "--out", str(out), "-n", "5", *options]) == 0
    return out


def test_each_frame_is_played_with_its_calibration(tmp_path, calibration):
    out = recorded(tmp_path / "scene.mcap", "--calibration", calibration, "--set", "BinningHorizontal=1")
    recording = open_recording(out)
    played = [recording.calibration(index) for index in range(5)]
    recording.close()
    assert all(np.array_equal(each.matrix, MATRIX) for each in played)
    assert np.array_equal(played[0].distortion, LENS)

    grabber = sources.create(f"file:{out}")
    grabber.open()
    grabber.start()
    assert until(grabber.calibration).matrix[0, 0] == 500
    grabber.close()


def test_rosbags_reads_the_folder(tmp_path, calibration):
    """An independent implementation: it checks the metadata and decodes the messages by their definitions."""
    rosbag2 = pytest.importorskip("rosbags.rosbag2", reason="rosbags is not installed: make setup")
    from rosbags.typesys import Stores, get_typestore

    out = recorded(tmp_path / "scene", "--bag", "--calibration", calibration)
    assert sorted(path.name for path in out.iterdir()) == ["metadata.yaml", "scene_0.mcap"]
    types = get_typestore(Stores.ROS2_HUMBLE)
    with rosbag2.Reader(out) as bag:
        assert bag.message_count == 20 and 0 < bag.duration < 5e9
        topics = {each.topic: (each.msgtype, each.msgcount) for each in bag.connections}
        assert topics == {
            "/grabbergui/image_raw": ("sensor_msgs/msg/Image", 5),
            "/grabbergui/camera_info": ("sensor_msgs/msg/CameraInfo", 5),
            "/grabbergui/image_raw/device_time": ("sensor_msgs/msg/TimeReference", 5),
            "/grabbergui/image_raw/note": ("std_msgs/msg/String", 5),
        }
        stamps = {}
        for connection, _, content in bag.messages():
            if connection.msgtype.endswith(("/Image", "/CameraInfo")):
                message = types.deserialize_cdr(content, connection.msgtype)
                stamps.setdefault(connection.topic, []).append(
                    (message.header.stamp.sec, message.header.stamp.nanosec)
                )
                if connection.msgtype.endswith("/CameraInfo"):
                    assert message.k.tolist() == MATRIX.ravel().tolist()
                    assert message.d.tolist() == LENS.tolist() and message.width == 64
    assert stamps["/grabbergui/image_raw"] == stamps["/grabbergui/camera_info"]

    recording = open_recording(out)
    assert len(recording) == 5 and recording.calibration(4).height == 48
    recording.close()


def test_a_message_keeps_region_and_binning():
    whole, part = Calibration(640, 480, MATRIX, LENS), Calibration(100, 50, MATRIX, LENS)
    fields = CameraInfoFields(stamp_ns=1_000_000_002, frame_id="eye")
    fill_camera_info(fields, FrameCalibration(part, whole, (8, 16, 200, 100), (2, 2)))
    again = CameraInfoFields.decode(fields.encode())
    assert again == fields and (again.roi.x_offset, again.roi.height, again.binning_x) == (8, 100, 2)
    assert (read_camera_info(again, "eye").width, read_camera_info(again, "eye").height) == (100, 50)


@pytest.mark.parametrize("options", [{"tiff": True}, {"codec": "h264"}, {"lossless": True}])
def test_a_bag_is_a_folder_and_the_only_option(tmp_path, options):
    assert kind_of(tmp_path / "scene", bag=True) is RecordingKind.BAG
    with pytest.raises(UsageError, match="leave out tiff, lossless and codec"):
        kind_of(tmp_path / "scene", bag=True, **options)
    with pytest.raises(UsageError, match=r"a bag is a folder.*: name .*scene, not .*scene\.mcap"):
        kind_of(tmp_path / "scene.mcap", bag=True)


def test_a_calibration_has_no_place_in_a_movie(tmp_path, calibration, capsys):
    command = ["record", SIM, "--out", str(tmp_path / "a.mp4"), "-n", "1", "--calibration", calibration]
    assert main(command) == 2
    assert "only .mcap and --bag" in capsys.readouterr().err

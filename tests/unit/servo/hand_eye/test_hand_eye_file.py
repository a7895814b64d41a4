"""The parts of `grabbergui hand-eye`: the target watch, the result, its file and frames, servoing by it."""

import errno
import os
import re
import sys
from argparse import Namespace
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

from grabbergui.calibration import geometry
from grabbergui.cli import command_parsers, main
from grabbergui.core.errors import SourceUnavailableError, UsageError
from grabbergui.net.ros2.camera_pose import publish_frame
from grabbergui.servo import closed_loop
from grabbergui.servo.cli import servo_robots
from grabbergui.servo.config import Config, MarkerConfig
from grabbergui.servo.hand_eye import hand_eye_file
from grabbergui.servo.hand_eye.hand_eye_file import CameraMount, static_transform_command
from grabbergui.servo.hand_eye.run import EYES, HandEyeRun
from grabbergui.servo.hand_eye.solver import HandEyeResult
from grabbergui.servo.hand_eye.stand import TargetWatch
from grabbergui.servo.models.hand_eye import HandEyeModel
from grabbergui.servo.robots import teo
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.ui import windows
from patience import until

CAMERA = geometry.pose(geometry.rotation_from_vector((0.3, -0.1, 0.2)), (0.07, 0.01, 0.06))
FOUND = HandEyeResult(CAMERA, np.eye(4), np.array([0.01, 0.0]), np.zeros(0), rms=0.3)


@pytest.mark.parametrize("eye", EYES)
def test_the_simulated_camera_shows_the_target_in_frames_that_are_new(eye):
    config = Config(marker=MarkerConfig(kind="charuco", size=0.03, columns=5, rows=4))
    robot = SimRobot(teo.MODEL, head=closed_loop.AT_BOARD)
    camera = closed_loop.hand_eye_camera(robot, config.marker, eye)
    camera.open()
    look = TargetWatch(camera, config.marker, closed_loop.calibration().scaled_to)
    try:
        seen = until(lambda: look(0.0), "a view of the target")
    finally:
        look.close()
        camera.close()
    assert seen.problem == ""
    assert len(seen.points) == len(seen.pixels) == 12


def test_a_result_names_its_frames_for_tf(tmp_path):
    turned = geometry.pose([[0, 0, 1], [-1, 0, 0], [0, -1, 0]])
    file, placement = tmp_path / "robot.yaml", CameraMount("hand", "hand_link", "eye_optical", turned)
    hand_eye_file.save(FOUND, file, placement)
    again = hand_eye_file.placement(file)
    assert (again.eye, again.mount, again.frame) == ("hand", "hand_link", "eye_optical")
    assert again.turned == pytest.approx(turned, abs=1e-9)
    assert hand_eye_file.load(file).camera == pytest.approx(CAMERA)
    words = static_transform_command(FOUND, again).split()
    place = (turned @ CAMERA)[:3, 3]
    given = [float(words[words.index(f"--{axis}") + 1]) for axis in "xyz"]
    assert given == pytest.approx(place, abs=1e-6)
    assert words[-4:] == ["--frame-id", "hand_link", "--child-frame-id", "eye_optical"]


def test_a_result_without_frames_has_none(tmp_path):
    file = tmp_path / "robot.yaml"
    hand_eye_file.save(FOUND, file)
    assert hand_eye_file.placement(file) is None
    file.write_text(file.read_text() + "transform: 7\n")
    with pytest.raises(UsageError, match="no names"):
        hand_eye_file.placement(file)


def test_servoing_takes_the_camera_from_the_file(tmp_path):
    robot, file = SimRobot(teo.MODEL), tmp_path / "robot.yaml"
    hand_eye_file.save(FOUND, file, CameraMount("head", "head", "camera"))
    servo_robots.place_camera(robot, file)
    angles = np.array([0.2, -0.1])
    tool = teo.HEAD.forward(angles + FOUND.camera_offsets)
    assert robot.camera_pose(angles) == pytest.approx(tool @ CAMERA)
    hand_eye_file.save(FOUND, file, CameraMount("fixed", "base", "camera"))
    with pytest.raises(UsageError, match="camera that stands"):
        servo_robots.place_camera(robot, file)


@pytest.mark.parametrize(
    ("robot", "eye", "mount"),
    [("sim-teo", "head", "head"), ("teo", "fixed", "base"), ("tiago", "head", "head_2_link")],
)
def test_frames_have_the_robot_s_names(robot, eye, mount):
    options = Namespace(robot=robot, eye=eye, mount_frame=None, camera_frame=None, hand_frame=None)
    placement = servo_robots.placement(options)
    assert (placement.mount, placement.frame) == (mount, "camera")
    assert (placement.turned == np.eye(4)).all()


def test_tiago_s_hand_has_other_axes_than_ours():
    options = Namespace(robot="tiago", eye="hand", mount_frame=None, camera_frame="eye", hand_frame="gripper")
    placement = servo_robots.placement(options)
    assert (placement.mount, placement.frame) == ("gripper", "eye")
    forward = placement.on_mount(np.eye(4))[:3, 2]
    assert forward == pytest.approx([1, 0, 0])


def test_a_frame_is_published_for_those_who_come_later(monkeypatch):
    def module(name, **entries):
        made = ModuleType(name)
        vars(made).update(entries)
        monkeypatch.setitem(sys.modules, name, made)

    def stamped(child_frame_id):
        vector = SimpleNamespace
        return vector(
            child_frame_id=child_frame_id,
            header=vector(frame_id="", stamp=None),
            transform=vector(translation=vector(), rotation=vector()),
        )

    for package in ("tf2_msgs", "geometry_msgs", "rclpy"):
        module(package)
    module("tf2_msgs.msg", TFMessage=lambda transforms: transforms)
    module("geometry_msgs.msg", TransformStamped=stamped)
    module("rclpy.qos", QoSProfile=dict, DurabilityPolicy=SimpleNamespace(TRANSIENT_LOCAL="latched"))
    sent = []
    node = SimpleNamespace(
        create_publisher=lambda kind, topic, qos: SimpleNamespace(
            publish=lambda message: sent.append((topic, qos, message))
        ),
        get_clock=lambda: SimpleNamespace(now=lambda: SimpleNamespace(to_msg=lambda: "now")),
    )
    publish_frame(node, "head", "camera", CAMERA)
    ((topic, qos, (entry,)),) = sent
    assert (topic, qos) == ("/tf_static", {"depth": 1, "durability": "latched"})
    assert (entry.header.frame_id, entry.child_frame_id) == ("head", "camera")
    assert [getattr(entry.transform.translation, axis) for axis in "xyz"] == pytest.approx(CAMERA[:3, 3])
    turn = [getattr(entry.transform.rotation, axis) for axis in "xyzw"]
    assert geometry.rotation_from_quaternion(*turn) == pytest.approx(CAMERA[:3, :3])


def test_without_tf_s_messages_it_says_what_to_do(monkeypatch):
    monkeypatch.setitem(sys.modules, "tf2_msgs.msg", None)
    with pytest.raises(SourceUnavailableError, match=r"tf2_msgs is not installed: source"):
        publish_frame(None, "head", "camera", CAMERA)


def test_a_result_that_could_not_be_written_is_refused_before_anything_moves(tmp_path, capsys):
    assert main(["hand-eye", "--out", str(tmp_path / "missing" / "robot.yaml")]) == 2
    assert "create it first" in capsys.readouterr().err


def test_a_result_that_cannot_be_saved_has_been_printed(tmp_path, monkeypatch, capsys):
    def refused(*arguments):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(HandEyeRun, "run", lambda run, views: FOUND)
    monkeypatch.setattr(hand_eye_file, "save", refused)
    assert main(["hand-eye", "--robot", "sim-teo", "--out", str(tmp_path / "robot.yaml")]) == 1
    shown = capsys.readouterr()
    assert "camera on head: 70.0 10.0 60.0 mm" in shown.out
    assert "--x 0.070000 --y 0.010000 --z 0.060000" in shown.out
    assert "saved" not in shown.out
    assert "No space left" in shown.err


def test_the_window_gets_robot_gate_frames_and_file(tmp_path, monkeypatch):
    stands = []

    def shown(stand, theme, stop):
        stands.append(stand)
        assert stand.gate.halted, "nothing moves before a person agrees"
        assert stand.why_not("fixed") == ""
        return FOUND

    monkeypatch.setattr(windows, "hand_eye", shown)
    file = tmp_path / "robot.yaml"
    command = ["hand-eye", "--window", "--robot", "sim-teo", "--eye", "hand", "--out", str(file)]
    assert main([*command, "--mount-frame", "wrist", "--target", "charuco", "--views", "7"]) == 0
    (stand,) = stands
    assert (stand.eye, stand.file, stand.config.marker.kind) == ("hand", file, "charuco")
    model = HandEyeModel(stand)
    assert (model.setup.eye, model.setup.views, model.plan().views) == ("hand", 7, 7)
    assert (stand.placement("hand").mount, stand.placement("head").eye) == ("wrist", "head")
    assert stand.gate.sent == 0


def test_a_window_that_is_closed_without_a_result_is_no_success(monkeypatch, capsys):
    """A script went on to servo with a file that had not been written."""
    monkeypatch.setattr(windows, "hand_eye", lambda stand, theme, stop: None)
    assert main(["hand-eye", "--window", "--robot", "sim-teo"]) == 1
    assert "the window was closed before there was a result" in capsys.readouterr().err


def test_the_manual_and_the_help_have_one_example():
    """Both set the simulated board's size: without it the robot sees nothing in 72 poses."""
    example = command_parsers()["hand-eye"][1].example
    page = (Path(__file__).parents[4] / "docs" / "servoing.md").read_text("utf-8")
    (written,) = re.findall(r"^grabbergui hand-eye --robot sim-teo .*$", page, re.MULTILINE)
    assert set(example.split()) <= set(written.split())

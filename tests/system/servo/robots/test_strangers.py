"""Faults over YARP: strangers at the ports of robot and program, bad images, and the record of the truth."""

import csv
import itertools
import time

import numpy as np
import pytest

from grabbergui.calibration import geometry
from grabbergui.core.frame_queue import FrameSink
from grabbergui.driver.sim.rendered_scene import Things
from grabbergui.net.yarp.os.values import Dialect
from grabbergui.servo import closed_loop
from grabbergui.servo.config import MarkerConfig
from grabbergui.servo.robots import teo
from grabbergui.servo.robots.fault_list import Fault
from grabbergui.servo.robots.faults import Faults
from grabbergui.servo.robots.faulty_camera import FaultyCamera, TruthRecorder
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.robots.strangers import YarpStranger
from grabbergui.servo.robots.teo_ports import TeoPorts
from grabbergui.servo.robots.teo_yarp import ARM, TeoOverYarp
from patience import until

UP = np.array([0.0, 0.0, 0.03, 0.0, 0.0, 0.0])


@pytest.fixture
def faulty(names, request):
    """A simulated TEO on YARP with the fault that the test names, from its first motion on."""
    robot = SimRobot(teo.MODEL, faults=Faults([Fault(request.param, 0.0)]))
    ports = TeoPorts(robot, names)
    ports.open()
    stranger = YarpStranger(robot, names, f"/teoSim{ARM}", Dialect.YARP3)
    stranger.start()
    yield robot
    stranger.close()
    ports.close()


@pytest.fixture
def client(names, faulty):
    client = TeoOverYarp(names)
    client.open()
    until(lambda: client.state() is not None)
    yield client
    client.close()


def place(state):
    return state.hand[:3, 3].copy()


@pytest.mark.parametrize("faulty", ["second-master"], indirect=True)
def test_a_second_master_moves_the_hand_until_a_stop(faulty, client):
    start = place(faulty.truth())
    client.move_hand(UP)  # announces twists, and begins the fault
    until(lambda: place(faulty.truth())[1] < start[1] - 0.05, "the second master's motion")
    until(client.stop, "a confirmed stop")  # a busy robot may confirm the second only
    until(lambda: faulty.speed < 1e-4)
    rests = place(faulty.truth())
    time.sleep(0.1)  # twenty of its messages
    assert place(faulty.truth()) == pytest.approx(rests, abs=1e-6)


@pytest.mark.parametrize("faulty", ["false-readings"], indirect=True)
def test_a_stranger_makes_the_program_believe_an_old_pose(faulty, client):
    start = place(faulty.truth())
    client.move_hand(UP)

    def believes():
        true, heard = place(faulty.truth()), place(client.state())
        return true[2] > start[2] + 0.03 and heard[2] < start[2] + 0.01

    until(believes)
    client.stop()


@pytest.mark.parametrize("faulty", ["readings-stop", "hand-jumps"], indirect=True)
def test_the_ports_stream_the_fault_and_the_controller_knows_better(faulty, client):
    client.move_hand(UP)
    until(lambda: faulty.speed > 0.01)
    if faulty.faults.active(np.inf) == ["readings-stop"]:
        until(lambda: time.monotonic() - client.state().time > 0.1)
    else:
        until(lambda: geometry.distance(client.state().hand, faulty.truth().hand) > 0.25)
    until(lambda: place(faulty.truth())[2] > place_at_home()[2] + 0.02)
    assert place(faulty.truth())[:2] == pytest.approx(place_at_home()[:2], abs=0.01)
    client.stop()


def place_at_home():
    return teo.RIGHT_ARM.forward(teo.HOME)[:3, 3]


@pytest.fixture
def frames(request):
    """Frames of a camera whose fault has begun."""
    robot = SimRobot(teo.MODEL, faults=Faults([Fault(request.param, 0.0)]))
    camera = closed_loop.mounted_camera(robot, closed_loop.things_for(MarkerConfig(), Things()))
    camera.open()
    faulty = FaultyCamera(camera, robot)
    faulty.open()
    received = []
    sink = FrameSink(faulty, received.append, name="reader", depth=20)
    sink.start()
    faulty.start()
    until(lambda: len(received) > 2)
    robot.faults.moved(robot.truth().time)
    before = len(received)
    until(lambda: len(received) > before + 6)
    yield [frame.detached() for frame in received[before + 1 :]]
    sink.stop()
    faulty.close()
    camera.close()
    robot.close()


@pytest.mark.parametrize("frames", ["images-alternate"], indirect=True)
def test_two_images_alternate_with_new_stamps(frames):
    images = [frame.payload.tobytes() for frame in frames]
    assert images[1:3] == images[3:5]
    assert images[1] != images[2]
    assert all(b.frame_id > a.frame_id and b.captured > a.captured for a, b in itertools.pairwise(frames))


@pytest.mark.parametrize(("frames", "mean"), [("images-dark", 0), ("images-noise", 127)], indirect=["frames"])
def test_an_image_is_dark_or_noise(frames, mean):
    assert frames[-1].rgb().mean() == pytest.approx(mean, abs=1)


def test_a_record_has_the_truth_and_the_faults(tmp_path):
    robot = SimRobot(teo.MODEL, faults=Faults([Fault("hand-jumps", 0.0)]))
    recorder = TruthRecorder(robot, tmp_path / "truth.csv")
    recorder.start()
    robot.move_hand(UP)
    until(lambda: "hand-jumps" in (tmp_path / "truth.csv").read_text("utf-8"))
    recorder.close()
    with (tmp_path / "truth.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert rows[0].keys() >= {"time", "x", "y", "z", "rx", "ry", "rz", "faults", *teo.RIGHT_ARM.joint_names}
    last = rows[-1]
    arm = [float(last[name]) for name in teo.RIGHT_ARM.joint_names]
    hand = teo.RIGHT_ARM.forward(arm)[:3, 3]
    assert [float(last[axis]) for axis in "xyz"] == pytest.approx(hand, abs=1e-5)

"""TEO's head moved by a real control board: `controlBoard_nws_yarp` over `fakeMotionControl`.

Run with `yarpdev` of YARP 3.12 or 4.0 on PATH; the arm's controller and the name server are ours.
"""

import os
import random
import shutil
import subprocess
import threading
import time

import numpy as np
import pytest

from grabbergui.core.errors import TransportError
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.name_server import NameServer
from grabbergui.servo.guardian_link import GuardianLink
from grabbergui.servo.robots import teo
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.robots.teo_ports import SimulatedCartesian
from grabbergui.servo.robots.teo_yarp import TeoOverYarp
from patience import PATIENCE, until

pytestmark = [
    pytest.mark.yarp,
    pytest.mark.skipif(not shutil.which("yarpdev"), reason="the program yarpdev is not on PATH"),
]

BOARD = """device deviceBundler
wrapper_device controlBoard_nws_yarp
attached_device fakeMotionControl
name /teoReal/head
period 0.01
[GENERAL]
Joints 2
[LIMITS]
Max (73 8.4)
Min (-73 -29)
"""


@pytest.fixture(scope="module")
def names():
    """Below the numbers that the system gives out itself: real YARP's ports get those just above."""
    for port in random.Random(os.getpid()).sample(range(11_000, 32_000, 100), 20):
        server = NameServer("127.0.0.1", port)
        try:
            server.open()
        except TransportError:
            continue
        yield NameClient(server.contact)
        server.close()
        return


@pytest.fixture(scope="module")
def board(names, tmp_path_factory):
    folder = tmp_path_factory.mktemp("yarp")
    (folder / "yarp.conf").write_text(f"{names.server.host} {names.server.port} yarp\n")
    (folder / "board.ini").write_text(BOARD)
    with (folder / "log").open("w") as log:
        device = subprocess.Popen(
            ["yarpdev", "--from", str(folder / "board.ini")],
            env={**os.environ, "YARP_CONFIG_HOME": str(folder)},
            stdout=log,
            stderr=log,
        )
    try:
        known = lambda: "/teoReal/head/stateExt:o" in {contact.name for contact in names.list()}  # noqa: E731
        until(lambda: known() or device.poll() is not None, "the real board's ports")
        if device.poll() is not None:
            pytest.skip("this YARP has no deviceBundler, controlBoard_nws_yarp or fakeMotionControl")
        yield device
    finally:
        device.kill()
        device.wait(PATIENCE)


@pytest.fixture(scope="module")
def arm(names):
    """A simulated arm that has the controller which the board's head lacks."""
    controller = SimulatedCartesian(SimRobot(teo.MODEL), names, "/teoReal/rightArm/CartesianControl")
    for port in controller.ports:
        port.open()
    running = threading.Event()
    running.set()

    def stream():
        while running.is_set():
            controller.step()
            time.sleep(0.01)

    thread = threading.Thread(target=stream)
    thread.start()
    yield controller
    running.clear()
    thread.join()
    for port in controller.ports:
        port.close()


@pytest.fixture
def robot(names, board, arm):
    client = TeoOverYarp(names, "/teoReal")

    def opens():
        """The ports are registered a moment before the board has its motors."""
        try:
            client.open()
        except TransportError:
            return False
        return True

    until(opens, "the real board's answer")
    until(lambda: client.state() is not None, "a reading")
    yield client
    client.close()


def head(robot):
    return np.degrees(robot.state().head)


def moved_at_the_loop_s_rate(move, by):
    """Repeat a command at 50 Hz until it has led far enough. A board queues commands that come faster."""
    return until(lambda: move() or time.sleep(0.02) or by())


def rests(robot):
    """Whether no joint moves for a while in which many readings came."""
    before = head(robot)
    time.sleep(0.2)
    return np.array_equal(head(robot), before)


def test_a_real_board_moves_by_velocities_and_stops(robot):
    before = head(robot)
    down = np.radians([10.0, -5.0])
    moved_at_the_loop_s_rate(lambda: robot.move_head(down), lambda: (head(robot) - before)[0] > 3)
    assert (head(robot) - before)[1] == pytest.approx(-(head(robot) - before)[0] / 2, abs=0.5)
    assert robot.stop()
    until(lambda: rests(robot))


def test_a_real_board_moves_by_requested_steps(robot):
    before = head(robot)
    robot.step_head(np.radians([2.0, -2.0]))
    until(lambda: np.allclose(head(robot) - before, [2, -2], atol=0.01))


def test_a_real_board_moves_by_short_positions_and_rests_at_the_last(robot):
    turning = np.radians([10.0, 5.0])
    robot.lead_head(turning, 0.1)  # entering the mode, this board goes to the last position that it had in it
    time.sleep(0.2)
    before = head(robot)
    moved_at_the_loop_s_rate(lambda: robot.lead_head(turning, 0.1), lambda: (head(robot) - before)[0] > 3)
    assert (head(robot) - before)[1] == pytest.approx((head(robot) - before)[0] / 2, abs=0.5)
    last = head(robot)
    until(lambda: rests(robot))
    assert (np.abs(head(robot) - last) < 2.5).all()


def test_the_guardian_stops_a_real_board(robot):
    """The program falls silent while the head obeys a velocity, which this board would keep for ever."""
    guardian = GuardianLink(robot.stop_channels(), 0.08)
    guardian.open()
    try:
        guardian.await_ready()
        before = head(robot)
        turning = np.radians([5.0, 0.0])
        moved_at_the_loop_s_rate(lambda: robot.move_head(turning), lambda: (head(robot) - before)[0] > 0.5)
        guardian.stop()
        until(lambda: rests(robot))
    finally:
        guardian.close()

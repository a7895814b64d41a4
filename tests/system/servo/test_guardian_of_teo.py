"""A whole program or its guardian, killed or frozen: how far TEO's hand still moves."""

import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from benchmarks.servo.servo_guardian import GOAL_MM, at_full_speed, moved_after, undisturbed
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.values import Dialect
from grabbergui.net.yarp.server import YarpGrabberServer
from grabbergui.servo import closed_loop
from grabbergui.servo.config import Config
from grabbergui.servo.robots import teo, teo_messages
from grabbergui.servo.robots.cartesian_messages import stop_control, twist
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.robots.teo_ports import TeoPorts
from grabbergui.servo.robots.teo_yarp import TeoOverYarp
from patience import PROGRAM, TRIES, allowance, until

CALIBRATION = Path(__file__).parents[3] / "resources/servo/teo-sim-camera.yaml"


@pytest.fixture
def simulated(names):
    robot = SimRobot(teo.MODEL)
    ports = TeoPorts(robot, names)
    with undisturbed():
        ports.open()
        yield robot
    ports.close()


@pytest.fixture
def server(names):
    """Return the address of the name server, as the command line takes it."""
    return f"{names.server.host}:{names.server.port}"


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP], ids=["killed", "frozen"])
def test_teo_s_hand_moves_less_than_30_mm_after_its_program_is(simulated, server, number):
    moved = []
    while not moved or moved[-1] >= GOAL_MM / 1000 * allowance():
        assert len(moved) < TRIES, f"the hand moved {moved} m"
        with at_full_speed(simulated, "teo", server) as program:
            moved.append(moved_after(simulated, program.process.pid, number))


@pytest.mark.parametrize(
    ("number", "why"),
    [(signal.SIGKILL, "has ended"), (signal.SIGSTOP, "does not answer")],
    ids=["killed", "frozen"],
)
def test_a_program_whose_guardian_is_stops_the_robot_first(simulated, server, number, why):
    with at_full_speed(simulated, "teo", server) as program:
        moved_after(simulated, program.guardian, number)
        assert program.said() == f"halted the guardian {why} (process {program.guardian})"


def test_a_program_that_is_killed_after_its_guardian_froze_leaves_the_hand_at_rest(simulated, server):
    """Nobody could stop it by then: the program has stopped it, because its guardian does not answer."""
    with at_full_speed(simulated, "teo", server) as program:
        moved_after(simulated, program.guardian, signal.SIGSTOP)
        assert program.said() == f"halted the guardian does not answer (process {program.guardian})"
        assert moved_after(simulated, program.process.pid, signal.SIGKILL) < 1e-4
        assert program.process.wait(PROGRAM) == -signal.SIGKILL
        assert simulated.speed < 1e-4


@pytest.mark.parametrize("dialect", Dialect)
def test_teos_stop_commands_keep_their_bytes_as_text(names, dialect):
    """Channels are declared as text; the bytes must be those that the robot receives otherwise."""
    ports = TeoPorts(SimRobot(teo.MODEL), names, dialect=dialect)
    ports.open()
    robot = TeoOverYarp(names)
    try:
        channels = robot.stop_channels()
    finally:
        robot.close()
        ports.close()
    assert {channel["dialect"] for channel in channels} == {dialect.value}
    reported = [Bottle.from_text(channel["stop"]).encode(dialect) for channel in channels]
    assert reported == [
        twist(np.zeros(6)).encode(dialect),
        teo_messages.velocity_moves(np.zeros(2), dialect).encode(dialect),
        teo_messages.stop_all(dialect).encode(dialect),
        stop_control().encode(dialect),
    ]


def test_the_program_itself_has_a_guardian(simulated, names, server):
    camera = closed_loop.mounted_camera(simulated, closed_loop.things_for(Config().marker))
    images = YarpGrabberServer(camera, "/teoSim/camera", names=names)
    options = [
        "--robot",
        "teo",
        "--nameserver",
        server,
        "--headless",
        "--no-keyboard",
        "--calibration",
        CALIBRATION,
    ]
    camera.open()
    images.start()
    program = subprocess.Popen(
        [sys.executable, "-m", "grabbergui", "servo", *options], stdout=subprocess.PIPE
    )
    try:
        until(lambda: b"approaching" in program.stdout.readline(), seconds=PROGRAM)
        until(lambda: simulated.speed > 0.05)
        moved_after(simulated, program.pid, signal.SIGSTOP)
        assert simulated.speed < 1e-3
    finally:
        program.kill()
        program.communicate()
        images.stop()
        camera.close()

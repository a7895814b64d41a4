"""Drives the hand at full speed until it is killed: `teo HOST:PORT`, or `tiago`.

A servo program without a camera, but with the real robot class, gate and guardian. It prints the guardian's
process id, "moving" once the hand moves, and finally the reason of the stop.
"""

import sys
import threading
import time
from dataclasses import replace

import numpy as np

from benchmarks._priority import run_as_others
from grabbergui.core.errors import GrabberError
from grabbergui.core.scheduling import run_first
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.servo.config import ArmConfig, Config
from grabbergui.servo.gate import Command, CommandGate
from grabbergui.servo.guardian_link import GuardianLink
from grabbergui.servo.robots.robot import Robot

SPEED = 0.15
"Metres per second."


def opened(kind: str, place: str) -> Robot:
    """Return the connected robot."""
    if kind == "teo":
        from grabbergui.servo.robots.teo_yarp import TeoOverYarp

        robot: Robot = TeoOverYarp(NameClient.find(place))
    else:
        from grabbergui.servo.robots import tiago
        from grabbergui.servo.robots.tiago_ros2 import TiagoOverRos2

        robot = TiagoOverRos2(tiago.model())
    robot.open()
    return robot


def main(kind: str, place: str = "") -> None:
    """Move the hand to and fro without end."""
    run_as_others()  # the guardian has to find its priority by itself
    robot = opened(kind, place)
    config = replace(Config(), arm=ArmConfig(fastest=SPEED))
    guardian = GuardianLink(robot.stop_channels(), config.safety.guardian_timeout, config.safety.lag)
    guardian.open()
    guardian.await_ready()
    run_first()  # on a busy machine late commands would stop it before it is fast
    gate = CommandGate(robot, config, guardian)
    print(f"guardian {guardian.pid}", flush=True)

    threading.Thread(target=gate.watch, args=(lambda: True,), daemon=True).start()
    while robot.state() is None:
        time.sleep(0.01)
    start = robot.state().hand[:3, 3].copy()  # type: ignore[union-attr]
    direction, said = 1.0, ""
    while True:
        height = robot.state().hand[2, 3] - start[2]  # type: ignore[union-attr]
        direction = -1.0 if height > 0.10 else 1.0 if height < -0.10 else direction
        gate.send(Command(hand=np.array([0, 0, direction * SPEED, 0, 0, 0])), time.monotonic())
        word = f"halted {gate.halted}" if gate.halted else "moving"
        if word != said:
            said = word
            print(word, flush=True)
        time.sleep(0.02)


if __name__ == "__main__":
    try:
        main(*sys.argv[1:])
    except GrabberError as error:
        sys.exit(str(error))

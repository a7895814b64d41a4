"""The whole loop in real time: a rendered camera, detection, control, and a robot's client."""

import math

from grabbergui.calibration import geometry
from grabbergui.driver.sim.rendered_scene import board_pose
from grabbergui.servo import closed_loop
from grabbergui.servo.runner import Runner
from grabbergui.servo.state_machine import State
from patience import PROGRAM, until


def detecting_runner(camera, robot, config):
    """A loop on an open camera that detects as the demonstration does."""
    return Runner(
        camera, robot, lambda frame: closed_loop.detector(config, closed_loop.calibration()), config
    )


def reach_marker(runner, simulated):
    """Run until the loop has reached the marker; return the hand's error, metres and degrees."""
    try:
        runner.start()
        until(lambda: runner.loop.machine.state is State.REACHED, seconds=PROGRAM)
    finally:
        runner.stop()
    goal = runner.loop.arm.goal(closed_loop.in_base(simulated, board_pose()))
    hand = simulated.state().hand
    return geometry.distance(hand, goal), math.degrees(geometry.angle_between(hand, goal))

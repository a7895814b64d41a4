"""An arm that is asked for anything, in simulated time: gate, monitor and a simulated robot, without images.

What is asked for, and what the robot reports, is drawn at random; the robot's true state is what counts.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from grabbergui.calibration import geometry
from grabbergui.servo.config import ArmConfig, Config
from grabbergui.servo.control import HAND_ON_MARKER, ArmController
from grabbergui.servo.gate import Command, CommandGate
from grabbergui.servo.robots.robot import KinematicModel
from grabbergui.servo.robots.simulated import SimRobot

PERIOD = 0.02
WORKSPACES = (
    Config(),
    Config(arm=ArmConfig(x_low=0.30, x_high=0.70, y_low=-0.55, y_high=-0.10)),
)


class FaultyRobot(SimRobot):
    """A simulated robot with a second master and readings that are wrong, from `begin` on."""

    fault = ""
    begin = math.inf

    def __init__(self, model, clock, seed):
        super().__init__(model, clock)
        self.clock, self.random = clock, np.random.default_rng(seed)
        self.direction = geometry.rotation_from_vector(self.random.uniform(-3, 3, 3))[:, 0]
        self.kept = None

    def state(self):
        true, since = super().state(), self.clock() - self.begin
        if since < 0:
            self.kept = true
            return true
        noise = self.random.normal(0, 1e-5, 3)
        if self.fault == "frozen but for noise":
            arm = self.kept.arm + self.random.normal(0, 1e-5, self.kept.arm.shape)
            return replace(self.kept, time=true.time, arm=arm, hand=self.model.arm.forward(arm))
        if self.fault == "lost":
            return replace(self.kept)
        off = {
            "jump": 0.3 * self.direction,
            "absurd": np.array([1e12, 0, 0]),
            "drift": 0.05 * since * self.direction,
            "stranger's pose": self.kept.hand[:3, 3] - true.hand[:3, 3] + 0.1 * self.direction + noise,
        }.get(self.fault)
        if off is None:
            return true
        hand = true.hand.copy()
        hand[:3, 3] += off
        return replace(true, hand=hand)

    def second_master(self):
        """Send another program's twist."""
        if self.fault == "second master" and self.clock() >= self.begin and not self.stopped:
            self.move_hand(np.concatenate((0.3 * self.direction, np.zeros(3))))

    stopped = False
    "Whether the robot's controller has taken a stop: other programs must then announce themselves again."

    def stop(self):
        self.stopped = self.clock() >= self.begin
        return super().stop()


@dataclass
class Outcome:
    fastest: float
    "Largest speed of the hand over 40 ms before the fault, m/s."
    outside: float
    "Metres by which it was outside the workspace before the fault, or further outside than at the start."
    joint_speed: float
    "Largest ratio of a joint's speed to its highest."
    stopped: str
    "Why the gate halted."
    stopped_after: float
    "Seconds from the fault to the stop."
    moved: float
    "Metres from the hand's place at the fault to the farthest afterwards."


FAULTS = ("second master", "jump", "absurd", "drift", "stranger's pose", "frozen but for noise")


def tried(model: KinematicModel, seed: int, fault: str = "", seconds: float = 3.0) -> Outcome:
    """Ask for a random marker, at rest or not, from a random pose near home; let a fault begin."""
    random, now = np.random.default_rng(seed), [0.0]
    config = WORKSPACES[seed % 2]
    low, high = config.arm.workspace
    robot = FaultyRobot(model, lambda: now[0], seed)
    gate, controller = CommandGate(robot, config), ArmController(config.arm, config.marker.standoff)
    turn = geometry.rotation_from_vector(random.uniform(-math.pi, math.pi, 3) * random.choice((0.2, 1.0)))
    goal = geometry.pose(robot.state().hand[:3, :3] @ turn, random.uniform(low - 0.05, high + 0.05))
    marker = goal @ geometry.inverse(geometry.pose(HAND_ON_MARKER, (0, 0, config.marker.standoff)))
    robot.fault, robot.begin = fault, random.uniform(0.3, 1.5) if fault else math.inf
    true = SimRobot.state
    places, angles, times, stopped_after = [], [], [], math.inf
    for _ in range(round(seconds / PERIOD)):
        state = true(robot)
        places.append(state.hand[:3, 3].copy())
        angles.append(state.arm)
        times.append(now[0])
        reading = robot.state()
        command = Command(hand=controller.approach(reading.hand, marker, PERIOD))
        if random.random() > 0.02:  # now and then a cycle is lost
            gate.send(command, now[0])
        robot.second_master()
        now[0] += PERIOD
        gate.expire(now[0])
        gate.beat(now[0])
        if gate.halted and math.isinf(stopped_after):
            stopped_after = now[0] - robot.begin
    places, angles, times = map(np.array, (places, angles, times))
    alone = times < robot.begin  # afterwards, false readings may lead anywhere until the stop
    speed = np.linalg.norm(places[2:] - places[:-2], axis=1) / (2 * PERIOD)
    outside = np.maximum(low - places, places - high).max(axis=1)
    after = places[times >= robot.begin - PERIOD]
    joints = np.abs(np.diff(angles, axis=0)).max(axis=0) / PERIOD / model.arm.fastest
    return Outcome(
        float(speed[alone[2:]].max()),
        float((outside - max(outside[0], 0.0))[alone].max()),
        float(joints.max()),
        gate.halted,
        stopped_after,
        float(np.linalg.norm(after - after[0], axis=1).max()) if len(after) else 0.0,
    )

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
from grabbergui.servo.robots.fault_list import Fault
from grabbergui.servo.robots.faults import Faults
from grabbergui.servo.robots.robot import KinematicModel
from grabbergui.servo.robots.simulated import SimRobot

PERIOD = 0.02
WORKSPACES = (
    Config(),
    Config(arm=ArmConfig(x_low=0.30, x_high=0.70, y_low=-0.55, y_high=-0.10)),
)


class ArmAmongStrangers(SimRobot):
    """A simulated robot with one fault, and the strangers that some faults are about."""

    def __init__(self, model, clock, seed, faults):
        random = np.random.default_rng(seed)
        self.direction = geometry.rotation_from_vector(random.uniform(-3, 3, 3))[:, 0]
        "Axis of the second master's twist, and of false poses."
        super().__init__(model, clock, faults=Faults(faults, direction=self.direction, seed=seed))
        self.outage = False
        "Whether the network loses commands and readings at present."
        self._before = super().state()
        "The last reading that came through."
        self.taken = False
        "Whether the controller has taken a stop since: a second master must then announce itself again."

    def state(self):
        if self.outage:
            return self._before
        reading = self._before = super().state()
        false = self.faults.false_reading(reading.time)
        if false is None:
            return reading
        hand = false.hand.copy()
        hand[:3, 3] += 0.1 * self.direction
        return replace(reading, hand=hand)

    def move_hand(self, twist):
        if not self.outage:
            super().move_hand(twist)

    def second_master(self, now):
        """Send another program's twist."""
        twist = self.faults.master_twist(now)
        if twist is not None and not self.taken:
            self.move_hand(np.concatenate((np.linalg.norm(twist) * self.direction, np.zeros(3))))

    def stop(self):
        if self.outage:
            return False
        self.taken = bool(self.faults.active(self.truth().time))
        return super().stop()


@dataclass(frozen=True)
class Pause:
    """A while in which this computer is too busy to run the program, or in which the network is."""

    begin: float = math.inf
    end: float = math.inf

    @staticmethod
    def drawn(random):
        begin = random.uniform(0.2, 2.0)
        return Pause(begin, begin + random.uniform(0.05, 0.4))

    def lasts(self, now):
        return self.begin <= now < self.end


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


FAULTS = ("second-master", "hand-jumps", "hand-far", "hand-drifts", "false-readings", "readings-freeze")


def tried(model: KinematicModel, seed: int, fault: str = "", seconds: float = 3.0) -> Outcome:
    """Ask for a random marker, at rest or not, from a random pose near home; let a fault begin."""
    random, now = np.random.default_rng(seed), [0.0]
    config = WORKSPACES[seed % 2]
    low, high = config.arm.workspace
    begins = [Fault(fault, random.uniform(0.3, 1.5))] if fault else []
    robot = ArmAmongStrangers(model, lambda: now[0], seed, begins)
    gate, controller = CommandGate(robot, config), ArmController(config.arm, config.marker.standoff)
    turn = geometry.rotation_from_vector(random.uniform(-math.pi, math.pi, 3) * random.choice((0.2, 1.0)))
    goal = geometry.pose(robot.state().hand[:3, :3] @ turn, random.uniform(low - 0.05, high + 0.05))
    marker = goal @ geometry.inverse(geometry.pose(HAND_ON_MARKER, (0, 0, config.marker.standoff)))
    places, angles, times, began, stopped = [], [], [], math.inf, math.inf

    def note():
        state = robot.truth()
        places.append(state.hand[:3, 3].copy())
        angles.append(state.arm)
        times.append(now[0])

    pauses = [Pause() if fault else Pause.drawn(random), Pause()]
    busy, quiet = random.permutation(pauses)
    while now[0] < seconds and not (gate.halted and robot.speed < 1e-6):
        note()
        reading = robot.state()
        robot.outage = quiet.lasts(now[0])
        twist = controller.approach(reading.hand, marker, PERIOD)
        if now[0] - reading.time > config.safety.robot_timeout:  # as the loop
            twist = controller.rest()
        if not busy.lasts(now[0]):
            if random.random() > 0.02:  # now and then a cycle is lost
                gate.send(Command(hand=twist), now[0])
        elif now[0] - busy.begin > config.safety.guardian_timeout:
            robot.stop()  # as the guardian
        robot.second_master(now[0])
        now[0] += PERIOD
        if not busy.lasts(now[0]):
            gate.expire(now[0])
            gate.beat(now[0])
        lasted = robot.faults.since(fault, now[0])
        began = began if lasted is None else now[0] - lasted
        if gate.halted:
            stopped = min(stopped, now[0])
    note()
    places, angles, times = map(np.array, (places, angles, times))
    alone = times < began  # afterwards, false readings may lead anywhere until the stop
    speed = np.linalg.norm(places[2:] - places[:-2], axis=1) / (2 * PERIOD)
    outside = np.maximum(low - places, places - high).max(axis=1)
    after = places[times >= began - PERIOD]
    joints = np.abs(np.diff(angles, axis=0)).max(axis=0) / PERIOD / model.arm.fastest
    return Outcome(
        float(speed[alone[2:]].max()),
        float((outside - max(outside[0], 0.0))[alone].max()),
        float(joints.max()),
        gate.halted,
        stopped - began,
        float(np.linalg.norm(after - after[0], axis=1).max()) if len(after) else 0.0,
    )

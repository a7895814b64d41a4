"""Cycles of the loop alone, without gate and images: what it commands, what it reports, what is tuned."""

import dataclasses

import numpy as np
import pytest

from grabbergui.calibration import geometry
from grabbergui.driver.sim.rendered_scene import at
from grabbergui.servo.config import ArmConfig, Config, HeadConfig, LoopConfig
from grabbergui.servo.control import off_centre
from grabbergui.servo.detection import Sighting
from grabbergui.servo.loop import FOLLOWED_M, ServoLoop
from grabbergui.servo.robots.robot import ARM, HEAD, RobotState
from grabbergui.servo.state_machine import State
from robots_for_tests import RecordingRobot, seeing

BOARD = at(0.70, -0.32, 0.36, yaw=4, pitch=-8)
PLACE = BOARD[:3, 3]
FACE = (1.35, -0.1, 0.8)
START = HeadConfig().start
SAFETY = Config().safety
DT = 0.02


class Bench:
    """A loop and a robot under one clock. The robot stays where it is, or obeys each command at once."""

    def __init__(self, *, obeys=False, dry_run=False, **sections):
        self.robot = RecordingRobot(floating=True)
        self.loop = ServoLoop(Config(**sections), self.robot, dry_run=dry_run)
        self.obeys = obeys
        self.loop.own_motion.shown = not obeys  # a head that stays where it is can show nothing

    def run(self, see, cycles=30):
        for _ in range(cycles):
            now = self.robot.time + DT
            self.robot.advance(now, DT)
            self.loop.see(see(now))
            cycle = self.loop.cycle(now, self.robot.state())
            if self.obeys:
                self.robot.velocity, self.robot.twist = cycle.command.head, cycle.command.hand
        return cycle

    def look_at(self, place, aside=0.0):
        """Turn the head so that the camera has a place in its middle, or radians to the right of it."""
        for _ in range(20):
            off = off_centre(np.asarray(place), self.robot.camera_pose(self.robot.head)) - (aside, 0)
            self.robot.head = self.robot.head - off * (1, -1)

    def board(self, now):
        return seeing(self.robot, now, BOARD)


def test_a_moment_has_what_the_loop_knew():
    bench = Bench()
    cycle = bench.run(lambda now: seeing(bench.robot, now, BOARD, FACE))
    moment = bench.loop.moment(cycle)
    assert moment.cycle is cycle and moment.sighting.captured == bench.robot.time
    assert moment.marker == pytest.approx(BOARD, abs=1e-6)
    assert moment.goal == pytest.approx(bench.loop.arm.goal(BOARD), abs=1e-6)
    assert moment.person == pytest.approx(FACE)
    cycle = bench.run(Sighting)
    moment = bench.loop.moment(cycle)
    assert moment.marker is moment.goal is moment.person is None
    assert np.isnan(cycle.off_centre).all() and np.isnan(cycle.error).all()


def test_what_is_tuned_are_head_arm_and_loop():
    bench = Bench()
    sections = {
        "head": HeadConfig(fastest=7.0),
        "arm": ArmConfig(fastest=0.01),
        "loop": dataclasses.replace(LoopConfig(), speed=0.5),
    }
    bench.loop.tune(Config(**sections))
    assert bench.loop.config == dataclasses.replace(Config(), **sections)
    cycle = bench.run(lambda now: seeing(bench.robot, now, face=(1.0, 1.0, 0.7)))
    assert np.degrees(np.abs(cycle.command.head)).max() == pytest.approx(7.0 / 2)
    bench.look_at(PLACE)
    cycle = bench.run(bench.board, 100)
    assert np.linalg.norm(cycle.command.hand[:3]) == pytest.approx(0.01 / 2)


def test_a_hand_that_may_follow_goes_along_with_a_marker_and_the_head_too():
    bench = Bench(obeys=True, arm=ArmConfig(follow=0.3))
    bench.look_at(PLACE)
    bench.run(bench.board, 400)
    assert bench.loop.machine.state is State.REACHED
    begun = bench.robot.time

    def moving(now):
        board = BOARD.copy()
        board[1, 3] += 0.1 * (now - begun)
        return seeing(bench.robot, now, board)

    cycle = bench.run(moving, 100)
    assert cycle.state is State.FOLLOWING
    assert cycle.command.hand[:3] == pytest.approx([0, 0.1, 0], abs=0.01)
    assert cycle.error[0] < 0.008 and cycle.error[1] < 0.01
    assert cycle.command.hand[3:] == pytest.approx([0, 0, 0], abs=0.01)
    assert cycle.command.head[0] == pytest.approx(0.1 / 0.7, rel=0.3)


def test_a_hand_that_may_not_follow_waits_until_the_marker_rests():
    bench = Bench(obeys=True)
    bench.look_at(PLACE)
    states = set()
    for step in range(150):
        board = BOARD.copy()
        board[1, 3] += 0.1 * DT * step
        states.add(bench.run(lambda now, board=board: seeing(bench.robot, now, board), 1).state)
    assert State.APPROACHING in states and State.FOLLOWING not in states


@pytest.mark.parametrize(
    ("state", "metres", "follows"),
    [
        (State.APPROACHING, 0.9 * FOLLOWED_M, True),
        (State.APPROACHING, 1.1 * FOLLOWED_M, False),
        (State.FOLLOWING, 1.9 * FOLLOWED_M, True),
        (State.FOLLOWING, 2.1 * FOLLOWED_M, False),
    ],
)
def test_a_hand_follows_once_it_is_near_until_it_is_left_behind(state, metres, follows):
    loop = Bench(arm=ArmConfig(follow=0.3)).loop
    loop.machine.state, loop.arm.error = state, (metres, 1.0)
    assert not loop._follows(), "the marker rests"
    for step in range(60):
        loop.motion.add(DT * step, np.array([0.0, 0.1 * DT * step, 0.0]))
    assert loop.motion.moving
    assert loop._follows() is follows


def test_the_hand_waits_until_the_marker_is_centred():
    bench = Bench()
    bench.look_at(PLACE, 1.5 * START)
    cycle = bench.run(bench.board, 60)
    assert cycle.state is State.CENTRING and not cycle.command.hand.any()
    bench.look_at(PLACE, 0.9 * START)
    assert bench.run(bench.board).state is State.APPROACHING


def test_a_head_that_is_not_driven_centres_nothing_and_the_hand_goes_on():
    bench = Bench()
    bench.loop._parts = {ARM}
    bench.look_at(PLACE, 1.5 * START)
    cycle = bench.run(bench.board, 60)
    assert cycle.state is State.APPROACHING
    assert cycle.command.hand.any() and not cycle.command.head.any()


def test_an_arm_that_is_not_driven_stays_and_the_head_goes_on():
    bench = Bench()
    bench.loop._parts = {HEAD}
    bench.look_at(PLACE)
    cycle = bench.run(bench.board, 60)
    assert cycle.state is State.WAITING
    assert cycle.reason == "the arm is not driven: only the head follows"
    assert not cycle.command.hand.any()


def test_a_person_may_move_a_little_while_the_marker_is_waited_for():
    bench = Bench(head=HeadConfig(below=0.0))
    for aside, state in ((0.0, State.WAITING), (2.4, State.WAITING), (2.6, State.CENTRING)):
        bench.look_at(FACE, aside * START)
        assert bench.run(lambda now: seeing(bench.robot, now, face=FACE), 40).state is state
    bench.look_at(FACE, 1.5 * START)
    assert bench.run(lambda now: seeing(bench.robot, now, face=FACE)).state is State.CENTRING


@pytest.mark.parametrize(
    ("held_back", "hindrance", "reason"),
    [
        ("the gate says no", "stretched", "the gate says no"),
        ("", "stretched", "stretched"),
        ("", "", "the arm does not get there"),
    ],
)
def test_why_a_hand_comes_no_nearer(held_back, hindrance, reason):
    loop = Bench().loop
    loop.held_back(held_back)
    asked = []
    loop._hindrance = lambda angles, twist: asked.append((angles, twist)) or hindrance
    hand, goal = geometry.pose(), geometry.pose(translation=(0.1, 0, 0))
    state = RobotState(1.0, np.zeros(2), hand, np.ones(6))
    assert loop._reason(state, goal) == reason
    for angles, twist in asked:
        assert angles.tolist() == [1.0] * 6 and twist == pytest.approx([0.1, 0, 0, 0, 0, 0])
    if not held_back:
        assert loop._reason(dataclasses.replace(state, arm=None), goal) == "the arm does not get there"


def approaching(**options):
    bench = Bench(**options)
    bench.look_at(PLACE)
    cycle = bench.run(bench.board, 40)
    assert cycle.state is State.APPROACHING and not cycle.command.halt and cycle.command.hand.any()
    return bench


@pytest.mark.parametrize("fault", ["no robot", "old robot", "old image", "future image", "stopped"])
def test_a_command_after_a_fault_is_a_halt(fault):
    bench = approaching()
    now = bench.robot.time + DT
    reading = bench.robot.state()
    if fault != "old robot":
        reading = dataclasses.replace(reading, time=now)
    if fault == "no robot":
        reading = None
    elif fault == "stopped":
        bench.loop.machine.stop(now, "pressed")
    elif fault == "future image":
        bench.loop.see(bench.board(now + 0.02))
    late = {"old robot": SAFETY.robot_timeout, "old image": SAFETY.image_timeout}.get(fault, 0.0)
    if fault not in ("old image", "future image"):
        bench.loop.see(bench.board(now + late))
    if fault == "old image":
        reading = dataclasses.replace(reading, time=now + late)
    cycle = bench.loop.cycle(now + late, reading)
    assert not cycle.state.head_moves
    assert cycle.command.halt and not cycle.command.hand.any() and not cycle.command.head.any()
    assert (cycle.time, cycle.robot) == (now + late, reading)
    assert cycle.reason == {
        "no robot": "the robot has not answered yet",
        "old robot": "the robot's readings are old",
        "stopped": "pressed",
    }.get(fault, "no fresh image")


def test_the_hand_speeds_up_by_the_time_that_passed_but_not_for_a_pause():
    bench, step = Bench(arm=ArmConfig(fastest=0.5)), ArmConfig().acceleration * DT
    bench.look_at(PLACE)
    speeds = [np.abs(bench.run(bench.board, 1).command.hand[:3]).max() for _ in range(12)]
    begun = next(index for index, speed in enumerate(speeds) if speed)
    assert speeds[begun : begun + 3] == pytest.approx([step, 2 * step, 3 * step])
    bench.robot.time += 1.0
    after = np.abs(bench.run(bench.board, 1).command.hand[:3]).max()
    assert speeds[-1] < after < speeds[-1] + 5.01 * step


def test_a_person_is_looked_at_below_the_face():
    bench = Bench(head=HeadConfig(below=0.3))
    cycle = bench.run(lambda now: seeing(bench.robot, now, face=FACE))
    place = np.array(FACE) - (0, 0, 0.3)
    assert cycle.off_centre == pytest.approx(off_centre(place, bench.robot.camera_pose(bench.robot.head)))


@pytest.mark.parametrize("speed", [1.0, 0.5])
def test_a_hand_that_does_not_come_nearer_is_stuck_until_a_stop_is_ended(speed):
    bench = approaching(loop=dataclasses.replace(LoopConfig(), speed=speed))
    patience = round(SAFETY.stuck / speed / DT)
    assert bench.run(bench.board, patience - 45).state is State.APPROACHING
    cycle = bench.run(bench.board, 50)
    metres, radians = cycle.error
    off = f"{1e3 * metres:.0f} mm and {np.degrees(radians):.0f}°"
    assert cycle.state is State.STUCK
    assert cycle.reason == f"the hand comes no nearer than {off}: the arm does not get there"
    bench.loop.machine.stop(bench.robot.time, "pressed")
    bench.run(bench.board, 2)
    bench.loop.machine.resume(bench.robot.time)
    assert bench.run(bench.board, 10).state is State.APPROACHING


def test_a_dry_run_says_so_and_nothing_is_stuck_in_it():
    assert "dry run" not in approaching().run(Sighting, 1).reason
    bench = approaching(dry_run=True)
    cycle = bench.run(bench.board, round(1.5 * SAFETY.stuck / DT))
    assert cycle.state is State.APPROACHING
    assert cycle.reason == "the marker is centred (dry run: nothing is sent)"

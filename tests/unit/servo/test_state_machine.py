"""Every transition, and none that should not be."""

import dataclasses
import itertools

import pytest

from every_case import every_case
from grabbergui.servo.state_machine import Situation, State, StateMachine, Transition

GRACE, SEARCH = 0.3, 2.0
STEP = 0.02

NOTHING = Situation()
PERSON_ASIDE = Situation(target=True)
PERSON = Situation(target=True, centred=True)
MARKER_ASIDE = Situation(target=True, marker=True)
MARKER = Situation(target=True, centred=True, marker=True)
ARRIVED = Situation(target=True, centred=True, marker=True, arrived=True, settled=True)
RESTLESS = dataclasses.replace(ARRIVED, settled=False)
MOVING = Situation(target=True, centred=True, marker=True, following=True)
STUCK = Situation(target=True, centred=True, marker=True, stuck="a joint is at its limit")
BLIND = Situation(images=False)
SILENT = Situation(robot=False)


class Run:
    def __init__(self):
        self.machine = StateMachine(GRACE, SEARCH)
        self.now = 100.0

    def feed(self, situation, seconds=STEP):
        for _ in range(max(1, round(seconds / STEP))):
            self.now += STEP
            state = self.machine.step(self.now, situation)
        return state


PATHS = {
    State.LOST: [],
    State.SEARCHING: [(NOTHING, SEARCH + 0.1)],
    State.CENTRING: [(PERSON_ASIDE, STEP)],
    State.WAITING: [(PERSON_ASIDE, 1.0), (PERSON, STEP)],
    State.APPROACHING: [(MARKER_ASIDE, 1.0), (MARKER, STEP)],
    State.FOLLOWING: [(MARKER_ASIDE, 1.0), (MARKER, STEP), (MOVING, STEP)],
    State.REACHED: [(MARKER_ASIDE, 1.0), (MARKER, STEP), (ARRIVED, 1.0)],
    State.STUCK: [(MARKER_ASIDE, 1.0), (MARKER, STEP), (STUCK, STEP)],
}


def in_state(state):
    run = Run()
    if state is State.STOPPED:
        run.machine.stop(run.now, "test")
        return run
    for situation, seconds in PATHS[state]:
        run.feed(situation, seconds)
    assert run.machine.state is state
    return run


def test_nothing_moves_before_anything_is_known():
    run = Run()
    assert (run.machine.state, run.machine.reason) == (State.LOST, "no image yet")
    assert run.feed(NOTHING) is State.LOST


@every_case(
    ("start", "situation", "seconds", "end"),
    [
        (State.LOST, NOTHING, SEARCH - 0.5, State.LOST),
        (State.LOST, NOTHING, SEARCH + 0.1, State.SEARCHING),
        (State.LOST, PERSON_ASIDE, STEP, State.CENTRING),
        (State.SEARCHING, NOTHING, 60, State.SEARCHING),
        (State.SEARCHING, PERSON_ASIDE, STEP, State.CENTRING),
        (State.CENTRING, PERSON_ASIDE, 60, State.CENTRING),
        (State.CENTRING, PERSON, STEP, State.WAITING),
        (State.CENTRING, MARKER_ASIDE, 60, State.CENTRING),
        (State.CENTRING, MARKER, STEP, State.APPROACHING),
        (State.CENTRING, NOTHING, GRACE - 0.1, State.CENTRING),
        (State.CENTRING, NOTHING, GRACE + 0.1, State.LOST),
        (State.WAITING, PERSON, 60, State.WAITING),
        (State.WAITING, PERSON_ASIDE, STEP, State.CENTRING),
        (State.WAITING, MARKER_ASIDE, STEP, State.CENTRING),
        (State.WAITING, MARKER, STEP, State.APPROACHING),
        (State.WAITING, NOTHING, GRACE + 0.1, State.LOST),
        (State.APPROACHING, MARKER, 60, State.APPROACHING),
        (State.APPROACHING, MARKER_ASIDE, 60, State.APPROACHING),
        (State.APPROACHING, ARRIVED, StateMachine.HOLD / 2, State.APPROACHING),
        (State.APPROACHING, ARRIVED, StateMachine.HOLD + 0.1, State.REACHED),
        (State.APPROACHING, RESTLESS, StateMachine.HOLD + 0.1, State.APPROACHING),
        (State.APPROACHING, RESTLESS, StateMachine.SETTLES + 0.1, State.REACHED),
        (State.APPROACHING, NOTHING, GRACE + 0.1, State.LOST),
        (State.REACHED, ARRIVED, 60, State.REACHED),
        (State.REACHED, MARKER, STEP, State.APPROACHING),
        (State.REACHED, NOTHING, GRACE + 0.1, State.LOST),
        (State.APPROACHING, STUCK, STEP, State.STUCK),
        (State.APPROACHING, dataclasses.replace(STUCK, arrived=True), 1.3, State.REACHED),
        (State.CENTRING, STUCK, STEP, State.STUCK),
        (State.WAITING, STUCK, STEP, State.STUCK),
        (State.STUCK, STUCK, 60, State.STUCK),
        (State.STUCK, MARKER, STEP, State.APPROACHING),
        (State.STUCK, PERSON, GRACE + STEP, State.LOST),
        (State.STUCK, NOTHING, GRACE + 0.1, State.LOST),
    ],
)
def test_a_situation_that_lasts_leads_from_one_state_to_the_next(start, situation, seconds, end):
    assert in_state(start).feed(situation, seconds) is end


@pytest.mark.parametrize("start", [State.APPROACHING, State.REACHED])
def test_a_marker_that_is_gone_is_lost_though_the_person_is_there(start):
    run = in_state(start)
    before = len(run.machine.transitions)
    run.feed(PERSON, GRACE + 0.2)
    passed = [step.state for step in run.machine.transitions[before:]]
    assert passed == [State.LOST, State.CENTRING, State.WAITING]


@every_case("start", [*PATHS])
@every_case("silence", [BLIND, SILENT])
def test_everything_is_lost_at_once_without_images_or_robot(start, silence):
    run = in_state(start)
    assert run.feed(silence) is State.LOST
    assert run.feed(silence, 60) is State.LOST
    # What comes after a silence is waited for, not searched for at once.
    assert run.feed(NOTHING, 1.0) is State.LOST


@pytest.mark.parametrize("start", [State.APPROACHING, State.FOLLOWING])
def test_the_hand_goes_on_at_once_after_a_moment_without_images(start):
    run = in_state(start)
    assert run.feed(BLIND, GRACE / 2) is State.LOST
    assert run.feed(MARKER_ASIDE) is State.APPROACHING


@pytest.mark.parametrize("start", [*PATHS])
def test_nothing_but_a_moving_hand_goes_on_after_a_moment_without_images(start):
    run = in_state(start)
    run.feed(BLIND)
    expected = State.APPROACHING if start.arm_moves else State.CENTRING
    assert run.feed(MARKER_ASIDE) is expected


@pytest.mark.parametrize(
    "silence",
    [
        [(BLIND, GRACE + STEP)],
        [(SILENT, STEP)],
        [(BLIND, STEP), (SILENT, STEP)],
        [(BLIND, STEP), (PERSON, STEP)],
    ],
    ids=["long", "robot", "both", "no marker"],
)
def test_after_any_other_silence_the_marker_is_centred_first(silence):
    run = in_state(State.FOLLOWING)
    for situation, seconds in silence:
        run.feed(situation, seconds)
    assert run.feed(MARKER_ASIDE) is State.CENTRING


def test_a_stop_in_a_moment_without_images_ends_the_motion_too():
    run = in_state(State.FOLLOWING)
    run.feed(BLIND)
    run.machine.stop(run.now, "pressed")
    run.machine.resume(run.now)
    assert run.feed(MARKER_ASIDE) is State.CENTRING


@pytest.mark.parametrize("start", [*PATHS])
def test_a_stop_holds_whatever_is_seen_until_it_is_ended(start):
    run = in_state(start)
    run.machine.stop(run.now, "pressed")
    for situation in (NOTHING, PERSON, MARKER, ARRIVED, BLIND, SILENT):
        assert run.feed(situation, 5) is State.STOPPED
    run.machine.resume(run.now)
    assert run.machine.state is State.LOST
    assert run.feed(MARKER_ASIDE) is State.CENTRING


def test_a_stop_and_its_end_are_noted_with_time_and_reason():
    run = Run()
    run.machine.stop(run.now + 1, "by a test")
    assert run.machine.reason == "by a test"
    run.machine.resume(run.now + 2)
    assert run.machine.reason == "resumed"
    assert run.machine.transitions == [
        Transition(run.now + 1, State.STOPPED, "by a test"),
        Transition(run.now + 2, State.LOST, "resumed"),
    ]


def test_a_goal_that_is_only_touched_is_not_reached():
    run = in_state(State.APPROACHING)
    for _ in range(20):
        assert run.feed(ARRIVED, StateMachine.HOLD * 0.6) is State.APPROACHING
        assert run.feed(MARKER) is State.APPROACHING


def test_a_hand_follows_until_the_marker_rests_or_is_lost():
    run = in_state(State.FOLLOWING)
    assert run.feed(MOVING, 5.0) is State.FOLLOWING
    assert run.feed(MARKER) is State.APPROACHING
    run.feed(MOVING)
    assert run.feed(NOTHING, GRACE + 0.1) is State.LOST


def test_only_approaching_and_following_move_the_arm_and_nothing_moves_when_lost_or_stopped():
    assert [state for state in State if state.arm_moves] == [State.APPROACHING, State.FOLLOWING]
    assert {state for state in State if not state.head_moves} == {State.LOST, State.STOPPED}


def test_every_change_is_noted_with_its_reason():
    machine = in_state(State.REACHED).machine
    assert [step.state for step in machine.transitions] == [
        State.CENTRING,
        State.APPROACHING,
        State.REACHED,
    ]
    assert all(step.reason for step in machine.transitions)
    assert all(a.time <= b.time for a, b in itertools.pairwise(machine.transitions))


@every_case(
    ("start", "situation", "seconds", "reason"),
    [
        (State.LOST, NOTHING, SEARCH + 0.1, "nothing to be seen"),
        (State.SEARCHING, PERSON_ASIDE, STEP, "a target is seen"),
        (State.LOST, PERSON_ASIDE, STEP, "a target is seen"),
        (State.CENTRING, PERSON, STEP, "centred; no marker yet"),
        (State.CENTRING, MARKER, STEP, "the marker is centred"),
        (State.CENTRING, STUCK, STEP, "a joint is at its limit"),
        (State.CENTRING, NOTHING, GRACE + 0.1, "the target is not seen"),
        (State.WAITING, PERSON_ASIDE, STEP, "the target is off centre"),
        (State.APPROACHING, PERSON, GRACE + STEP, "the marker is not seen"),
        (State.APPROACHING, STUCK, STEP, "a joint is at its limit"),
        (State.APPROACHING, ARRIVED, StateMachine.HOLD + 0.1, "the hand is at the marker"),
        (State.APPROACHING, MOVING, STEP, "the hand goes along with the marker"),
        (State.FOLLOWING, MARKER, STEP, "the marker rests, or it is too fast to be followed"),
        (State.REACHED, MARKER, STEP, "the marker moved"),
        (State.STUCK, MARKER, STEP, "the marker moved"),
        (State.APPROACHING, BLIND, STEP, "no fresh image"),
        (State.APPROACHING, SILENT, STEP, "the robot does not answer"),
    ],
)
def test_each_change_says_when_and_why(start, situation, seconds, reason):
    run = in_state(start)
    run.feed(situation, seconds)
    last = run.machine.transitions[-1]
    assert (run.machine.reason, last.reason) == (reason, reason)
    assert run.now - STEP * 5 <= last.time <= run.now + 1e-9


def test_a_hand_that_goes_on_says_that_images_come_again():
    run = in_state(State.APPROACHING)
    run.feed(BLIND)
    run.feed(MARKER_ASIDE)
    assert run.machine.reason == "images arrive again"
    assert run.machine.transitions[-1] == Transition(run.now, State.APPROACHING, "images arrive again")


@pytest.mark.parametrize("start", [State.CENTRING, State.APPROACHING])
def test_a_loss_names_the_problem_if_there_is_one(start):
    run = in_state(start)
    run.feed(Situation(problem="it is seen edge-on"), GRACE + 0.1)
    assert run.machine.state is State.LOST
    assert run.machine.reason == "it is seen edge-on"


@pytest.mark.parametrize(("start", "named"), [(State.WAITING, True), (State.CENTRING, False)])
def test_a_problem_is_named_while_the_marker_is_waited_for(start, named):
    run = in_state(start)
    before = run.machine.reason
    run.feed(dataclasses.replace(PERSON_ASIDE, centred=named, problem="several markers 20"))
    assert run.machine.state is start
    assert run.machine.reason == ("several markers 20" if named else before)

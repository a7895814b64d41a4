"""Planned cameras lose nothing at 90 % of the line through a switch with a finite buffer; others do."""

import heapq

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grabbergui.models.language import driver_text, set_translator
from grabbergui.rig.link_budget import ETHERNET, CameraLoad, Pacing, SharedLink, plan

GIGABIT = SharedLink()


class Switch:
    """A store-and-forward switch: an output at the link's rate behind a buffer; times in seconds."""

    def __init__(self, rate, buffer):
        self.rate, self.buffer = rate, buffer
        self.free_at = 0.0
        self.dropped = self.passed = 0
        self.fullest = 0.0

    def take(self, time, size):
        waiting = max(0.0, self.free_at - time) * self.rate
        if waiting + size > self.buffer:
            self.dropped += 1
            return
        self.fullest = max(self.fullest, waiting + size)
        self.passed += 1
        self.free_at = max(self.free_at, time) + size / self.rate


def packets(load, pause, delay, frames, phase=0.0):
    """Yield the times at which a camera's packets have reached the switch, and their sizes."""
    on_wire = load.packet_size + ETHERNET
    clock = 0.0
    for frame in range(frames):
        clock = max(clock, frame / load.frame_rate + phase + delay)  # a frame waits for the one before
        for _ in range(load.packets):
            yield clock + on_wire / load.link, on_wire
            clock += on_wire / load.link + pause


def send(budget, frames, planned, phases=()):
    """Trigger all cameras together and return the switch afterwards."""
    switch = Switch(budget.link.rate, budget.link.buffer)
    streams = []
    for index, each in enumerate(budget.allotments):
        seconds = {name: value / each.load.tick_frequency for name, value in each.settings.items()}
        pause = seconds.get("GevSCPD", 0) if planned else 0
        delay = seconds.get("GevSCFTD", 0) if planned else 0
        phase = phases[index] if phases else 0.0
        streams.append(packets(each.load, pause, delay, frames, phase))
    for time, size in heapq.merge(*streams):
        switch.take(time, size)
    return switch


def six(fraction=0.9, **more):
    """Six equal cameras that need a fraction of a gigabit link."""
    load = CameraLoad("", 1224 * 1024, 1.0, **more)
    rate = fraction * GIGABIT.rate / 6 / load.frame_on_wire
    return [CameraLoad(f"camera{n}", 1224 * 1024, rate, **more) for n in range(6)]


def test_six_cameras_at_90_percent_lose_nothing_when_planned_and_much_when_not():
    budget = plan(six(0.899), GIGABIT)
    assert budget.fits
    planned, unplanned = send(budget, 4, planned=True), send(budget, 4, planned=False)
    assert planned.dropped == 0 and planned.fullest < 16_000
    assert unplanned.dropped > 0.5 * unplanned.passed


@settings(max_examples=8)
@given(
    st.lists(
        st.tuples(
            st.integers(30_000, 900_000),
            st.floats(0.2, 5),
            st.sampled_from([576, 1500, 9000]),
            st.floats(0, 0.02),
        ),
        min_size=2,
        max_size=6,
    )
)
def test_different_cameras_that_fit_lose_nothing_whatever_their_phases(cameras):
    shapes = [
        CameraLoad(f"c{n}", size, weight, packet) for n, (size, weight, packet, _) in enumerate(cameras)
    ]
    factor = 0.899 * GIGABIT.rate / sum(load.need for load in shapes)
    loads = [
        CameraLoad(load.name, load.payload, load.frame_rate * factor, load.packet_size) for load in shapes
    ]
    budget = plan(loads, GIGABIT)
    assert budget.fits
    assert send(budget, 3, planned=True, phases=[phase for *_, phase in cameras]).dropped == 0
    for each in budget.allotments:  # a frame is sent before the next one
        assert each.frame_time <= 1.001 / each.load.frame_rate


def test_cameras_that_can_only_delay_frames_send_in_turns():
    budget = plan(six(0.85, means=(Pacing.FRAME_DELAY,)), GIGABIT)
    delays = [each.settings["GevSCFTD"] for each in budget.allotments]
    assert delays == sorted(set(delays)) and delays[0] == 0
    assert send(budget, 3, planned=True).dropped == 0


def test_a_usb_camera_gets_a_throughput_limit():
    (each,) = plan(
        [CameraLoad("u", 2_000_000, 30, 0, 400e6, means=(Pacing.THROUGHPUT_LIMIT,))], SharedLink(400e6)
    ).allotments
    assert each.settings == {"DeviceLinkThroughputLimit": 360_000_000}


def test_what_does_not_fit_says_by_how_much():
    budget = plan(six(1.2), GIGABIT)
    (problem,) = budget.problems
    assert "need 150.0 MB/s" in problem and "112.5 MB/s" in problem and "to 75% of it" in problem
    (problem,) = plan([CameraLoad("slow", 10**6, 20, link=12.5e6)], GIGABIT).problems
    assert "slow needs" in problem and "own cable" in problem


def test_cameras_without_means_are_named_if_the_buffer_is_too_small():
    loads = six(0.5, means=())
    (problem,) = plan(loads, GIGABIT).problems
    assert "camera0, camera1" in problem and "128 kB" in problem
    assert plan(loads, SharedLink(buffer=100e6)).fits
    assert send(plan(loads, GIGABIT), 1, planned=True).dropped > 0


def test_the_window_says_what_does_not_fit_in_the_users_language():
    slow = plan([CameraLoad("slow", 10**6, 20, link=12.5e6)], GIGABIT)
    problems = [each for budget in (plan(six(1.2), GIGABIT), slow) for each in budget.problems]
    problems += plan(six(0.5, means=()), GIGABIT).problems
    set_translator(lambda context, text: f"[{text}]")
    shown = [driver_text(each) for each in problems]
    set_translator(None)
    assert len(problems) == 3 and shown == [f"[{each}]" for each in problems]


def test_the_table_explains_every_camera():
    table = plan(six(0.899), GIGABIT).table()
    assert [row[0] for row in table] == ["camera", *(f"camera{n}" for n in range(6)), "all"]
    assert all(len(row) == len(table[0]) for row in table)
    assert table[1][-1].startswith("GevSCPD=") and table[-1][-1] == "90% of 125.0 MB/s"


@pytest.mark.parametrize("frequency", [1_000_000_000, 125_000_000, 1_000_000])
def test_the_delay_is_in_the_cameras_ticks(frequency):
    budget = plan(six(0.899, tick_frequency=frequency), GIGABIT)
    assert send(budget, 2, planned=True).dropped == 0

"""Injected faults of triggers are named rightly, and none is named when all is well.

The camera is the simulated one, on a clock of numbers.
"""

import random
from dataclasses import replace

from every_case import every_case
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.enumerations import EventSelector, TriggerActivation, TriggerOverlap, TriggerSource
from grabbergui.driver.sim.model import CameraModel
from grabbergui.driver.sim.timing import FRAME_START, SimulatedClock
from grabbergui.rig.trigger_diagnosis import ActionKeys, TriggerCause, TriggerEvidence, diagnose

TRIES = 20
"Runs with each fault and different signals; 100 were tried once."
PULSES = 30
MS = 1_000_000
EVENTS = {
    EventSelector.LINE1_RISING_EDGE: "rising",
    EventSelector.LINE1_FALLING_EDGE: "falling",
    EventSelector.FRAME_TRIGGER_MISSED: "missed",
}


class Bench:
    """A simulated camera under a trigger, with what its host sees."""

    def __init__(self, seed, source=TriggerSource.LINE1, *, burst=False):
        self.random = random.Random(seed)
        self.time = 10**9
        clock = SimulatedClock(lambda: self.time, drift=self.random.uniform(-50e-6, 50e-6))
        self.model = model = CameraModel(clock=clock)
        memory = model.memory
        self.exposure = self.random.randint(1_000, 20_000)
        memory.set(reg.EXPOSURE_TIME, float(self.exposure))
        memory.set(reg.HEIGHT, self.random.choice([480, 1024, 2048]))
        memory.set(reg.TRIGGER_OVERLAP[FRAME_START], self.random.choice(list(TriggerOverlap)))
        self.trigger = 1 if burst else FRAME_START
        memory.set(reg.TRIGGER_MODE[self.trigger], 1)
        memory.set(reg.TRIGGER_SOURCE[self.trigger], source)
        for event in EVENTS:
            memory.set(reg.EVENT_NOTIFICATION[event], 1)
        self.seen = {"rising": [], "falling": [], "missed": []}
        model.on_event = lambda event, frame_id, at: self.seen[EVENTS[event]].append(at)
        self.frames = []
        self.readout = round(memory.integer(reg.HEIGHT) * reg.LINE_TIME_US + reg.FRAME_OVERHEAD_US)
        overlaps = memory.integer(reg.TRIGGER_OVERLAP[FRAME_START]) == TriggerOverlap.READ_OUT
        both = self.exposure, self.readout
        self.shortest = (max(both) if overlaps else sum(both)) * 1000
        model.write(reg.ACQUISITION_START.address, (1).to_bytes(4, "big"))
        self.evidence = TriggerEvidence(
            "Line1",
            exposure_ns=self.exposure * 1000,
            readout_ns=self.readout * 1000,
            overlapping=overlaps,
        )

    def pulses(self, period, count=PULSES):
        """Return times of pulses with a little jitter."""
        begin = self.time + 50 * MS
        return [begin + round((n + self.random.uniform(-0.01, 0.01)) * period) for n in range(count)]

    def run(self, moments):
        """Perform actions at their times, and receive all frames."""
        for moment, act in sorted(moments, key=lambda pair: pair[0]):
            self.advance(moment)
            act()
        self.advance(self.time + 10**9)

    def advance(self, moment):
        self.time = moment
        while (plan := self.model.next_frame(0)) is not None:
            self.frames.append(plan)

    def levels(self, pulses, width):
        """Return the actions that put pulses on the line."""
        high, low = (lambda level=level: self.model.set_input(level) for level in (True, False))
        return [(time, high) for time in pulses] + [(time + width, low) for time in pulses]

    def result(self, lost=(), **more):
        frames = [plan for plan in self.frames if plan.frame_id not in lost]
        edges = {name: tuple(times) for name, times in self.seen.items()}
        return diagnose(
            replace(
                self.evidence,
                frames=tuple(plan.timestamp_ns for plan in frames),
                lost=len(self.frames) - len(frames),
                **{"level": False, **edges, **more},
            )
        )


def slow(bench):
    """Return a period that the camera can follow."""
    return max(bench.random.uniform(1.2, 3) * (bench.shortest + MS), 12 * MS)


def well(seed):
    bench = Bench(seed)
    bench.run(bench.levels(bench.pulses(slow(bench)), 2 * MS))
    assert len(bench.frames) == PULSES
    return bench.result()


def no_signal(seed):
    bench = Bench(seed)
    bench.run([])
    return bench.result()


def missing(seed):
    bench = Bench(seed)
    pulses = bench.pulses(slow(bench))
    for gone in bench.random.sample(range(2, PULSES - 2), bench.random.randint(1, 3)):
        pulses[gone] = pulses[gone - 1]
    bench.run(bench.levels(sorted(set(pulses)), 2 * MS))
    return bench.result()


def double(seed):
    bench = Bench(seed)
    period = slow(bench)
    pulses = bench.pulses(period)
    for pulse in bench.random.sample(pulses, bench.random.randint(1, 4)):
        pulses.append(pulse + round(bench.random.uniform(0.12, 0.3) * period))
    bench.run(bench.levels(sorted(set(pulses)), MS // 2))
    return bench.result()


def bouncing(seed):
    bench = Bench(seed)
    pulses = bench.pulses(slow(bench))
    moments = bench.levels(pulses, 3 * MS)
    for at in bench.random.sample(pulses, bench.random.randint(3, PULSES)):
        for _ in range(bench.random.randint(1, 3)):
            at += bench.random.randint(20_000, 100_000)
            moments.append((at, lambda: bench.model.set_input(False)))
            at += bench.random.randint(20_000, 100_000)
            moments.append((at, lambda: bench.model.set_input(True)))
    bench.run(moments)
    return bench.result()


def too_fast(seed):
    bench = Bench(seed)
    bench.run(bench.levels(bench.pulses(bench.random.uniform(0.55, 0.93) * bench.shortest), MS // 4))
    found = bench.result()
    assert f"allow {1e9 / bench.shortest:.1f} Hz" in found.sentence
    return found


def wrong_edge(seed):
    bench = Bench(seed)
    if bench.random.random() < 0.5:
        bench.model.memory.set(reg.LINE_INVERTER[0], 1)
    else:
        falling = TriggerActivation.FALLING_EDGE
        bench.model.memory.set(reg.TRIGGER_ACTIVATION[FRAME_START], falling)
        bench.evidence = replace(bench.evidence, activation="FallingEdge")
    pulses = bench.pulses(slow(bench))
    bench.run(bench.levels(pulses, bench.random.randint(MS // 4, 3 * MS)))
    clock = bench.model.device_clock
    return bench.result(sent=tuple(map(clock.to_device, pulses)))


def well_with_a_leader(seed):
    bench = Bench(seed)
    pulses = bench.pulses(slow(bench))
    bench.run(bench.levels(pulses, bench.random.randint(MS // 4, 3 * MS)))
    shift = bench.random.randint(-300_000, 300_000)  # of the leader's clock
    clock = bench.model.device_clock
    return bench.result(sent=tuple(clock.to_device(time) + shift for time in pulses), clock_ns=300_000)


def busy_leader(seed):
    """A leader that leaves exposures out and makes others early; some of its frames and events are lost."""
    bench = Bench(seed)
    period = slow(bench)
    pulses = bench.pulses(period)
    for late in bench.random.sample(range(1, PULSES), 6):
        shift = round(bench.random.uniform(0.1, 5.8) * period)
        pulses[late:] = [time + shift for time in pulses[late:]]
    hurried = bench.random.randrange(2, PULSES)
    shift = max(0, pulses[hurried] - pulses[hurried - 1] - bench.shortest - 2 * MS)
    pulses[hurried:] = [time - shift for time in pulses[hurried:]]
    bench.run(bench.levels(pulses, bench.random.randint(MS // 4, 2 * MS)))
    del bench.seen["rising"][bench.random.randrange(PULSES)]
    sent = bench.random.sample(pulses, PULSES - seed % 4)
    clock = bench.model.device_clock
    return bench.result(sent=tuple(sorted(map(clock.to_device, sent))), sent_lost=seed % 4, clock_ns=200_000)


def encoder(seed):
    """A conveyor that changes its speed and stands still for a while."""
    bench = Bench(seed)
    period, at, pulses = slow(bench), bench.time + 50 * MS, []
    for number in range(PULSES):
        pulses.append(at)
        at += round(period * (1 + 2 * abs(number - PULSES / 2) / PULSES))
        if number == 7:
            at += round(period * bench.random.uniform(1, 20))
    bench.run(bench.levels(pulses, 2 * MS))
    return bench.result()


def paused(seed):
    """A regular signal that begins again after a pause."""
    bench = Bench(seed)
    period = slow(bench)
    pulses = bench.pulses(period)
    pause = round(period * bench.random.uniform(10, 50))
    pulses[12:] = [time + pause for time in pulses[12:]]
    bench.run(bench.levels(pulses, 2 * MS))
    del bench.seen["rising"][bench.random.randrange(PULSES)]  # its event is lost, its frame is there
    return bench.result()


KEYS = ActionKeys(7, 3, 5)


def actions(seed, keys=KEYS, reach=lambda number: True, acknowledged=PULSES):
    """Send actions to a camera that accepts KEYS; those that `reach` are acknowledged if they are meant."""
    bench = Bench(seed, TriggerSource.ACTION1)
    pulses = bench.pulses(slow(bench))
    arriving = [time for number, time in enumerate(pulses) if reach(number)]
    meant = not keys.refused_because(KEYS)
    bench.run([(time, bench.model.trigger_action) for time in arriving] if meant else [])
    return bench.result(
        source="Action1",
        sent=tuple(pulses),
        action=keys,
        accepted=KEYS,
        acknowledged=min(len(arriving), acknowledged) if meant else 0,
    )


def late_acknowledges(seed):
    return actions(seed, acknowledged=PULSES - 1 - seed % 4)


def wrong_keys(seed):
    which = seed % 3
    wrong = [ActionKeys(8, 3, 5), ActionKeys(7, 4, 5), ActionKeys(7, 3, 0xA)][which]
    found = actions(seed, wrong)
    assert ("ActionDeviceKey", "ActionGroupKey", "ActionGroupMask")[which] in found.sentence
    return found


def lost_action(seed):
    gone = set(random.Random(seed).sample(range(PULSES), 1 + seed % 4))
    return actions(seed, reach=lambda number: number not in gone)


def burst_not_full(seed):
    bench = Bench(seed, burst=True)
    wanted = bench.random.randint(2, 5)
    memory = bench.model.memory
    memory.set(reg.BURST_FRAME_COUNT, wanted)
    memory.set(reg.TRIGGER_MODE[FRAME_START], 1)  # left on by mistake; it waits for the same line
    memory.set(reg.TRIGGER_SOURCE[FRAME_START], TriggerSource.LINE1)
    bench.run(bench.levels(bench.pulses(wanted * slow(bench)), 2 * MS))
    return bench.result(burst_frames=wanted, frame_start_waits=True)


def lost_frame(seed):
    bench = Bench(seed)
    bench.run(bench.levels(bench.pulses(slow(bench)), 2 * MS))
    return bench.result(lost=set(bench.random.sample(range(2, PULSES), bench.random.randint(1, 3))))


FAULTS = {
    well: TriggerCause.NONE,
    well_with_a_leader: TriggerCause.NONE,
    busy_leader: TriggerCause.NONE,
    encoder: TriggerCause.NONE,
    paused: TriggerCause.NONE,
    late_acknowledges: TriggerCause.NONE,
    actions: TriggerCause.NONE,
    no_signal: TriggerCause.NO_SIGNAL,
    missing: TriggerCause.PULSES_MISSING,
    double: TriggerCause.DOUBLE,
    bouncing: TriggerCause.BOUNCING,
    too_fast: TriggerCause.TOO_FAST,
    wrong_edge: TriggerCause.WRONG_EDGE,
    wrong_keys: TriggerCause.ACTION_KEYS,
    lost_action: TriggerCause.ACTION_LOST,
    burst_not_full: TriggerCause.BURST_NOT_FULL,
    lost_frame: TriggerCause.FRAME_LOST,
}


@every_case("fault", FAULTS, ids=lambda fault: fault.__name__)
def test_each_fault_is_named_rightly(fault):
    for seed in range(TRIES):
        found = fault(seed)
        assert found.cause is FAULTS[fault], (seed, found)
        assert bool(found.sentence) == (found.cause is not TriggerCause.NONE)


def test_a_rolling_shutter_without_overlap_is_explained():
    exposure, readout = 15 * MS, 15 * MS
    period = 1_000_000_000 // 45
    pulses = tuple(n * period for n in range(45))
    evidence = TriggerEvidence(
        "Line1",
        rising=pulses,
        falling=tuple(time + MS for time in pulses),
        frames=pulses[::2],
        missed=pulses[1::2],
        exposure_ns=exposure,
        readout_ns=readout,
        overlapping=False,
    )
    found = diagnose(evidence)
    assert found.cause is TriggerCause.TOO_FAST
    assert "come at 45.0 Hz" in found.sentence and "allow 33.3 Hz" in found.sentence
    assert "with it 66.7 Hz" in found.sentence


def test_a_camera_without_events_of_its_line_is_diagnosed_by_its_level():
    found = diagnose(TriggerEvidence("Line1", level=True))
    assert found.cause is TriggerCause.NO_SIGNAL and "it is high" in found.sentence

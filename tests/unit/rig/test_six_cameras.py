"""Six cameras with drifting clocks, jitter and loss, from fitted clocks to sets; times are numbers.

10,000 sets were tried once; see docs/rig.md.
"""

import heapq

import numpy as np
import pytest

from grabbergui.rig.clock_fit import ClockFit
from grabbergui.rig.frame_sets import FrameStamp, MatchByTime, SetTimes

NAMES = tuple("abcdef")
SECOND = 1_000_000_000
PERIOD = SECOND // 30
LOSS = 0.01
LEAST_DELAY = 8_000_000
"Readout and transfer, in ns."


def journey(sets, seed, *, readings):
    """Return matched sets, the errors of the clocks beside what was stated, and the matcher.

    With `readings` the clocks are read once a second; otherwise only arrivals tell of them.
    """
    random = np.random.default_rng(seed)
    offsets = random.integers(0, 10**15, len(NAMES)).tolist()
    drifts = random.uniform(-50e-6, 50e-6, len(NAMES))
    device = [lambda host, o=o, d=d: o + round(host * (1 + d)) for o, d in zip(offsets, drifts, strict=True)]
    fits = [ClockFit(least_delay_ns=(LEAST_DELAY, LEAST_DELAY)) for _ in NAMES]
    estimates = [None] * len(NAMES)
    events = []
    for index in range(sets):
        for camera in range(len(NAMES)):
            if random.random() < LOSS:
                continue
            exposed = index * PERIOD + int(random.integers(-20_000, 20_000))
            arrival = exposed + LEAST_DELAY + int(random.exponential(400_000))
            heapq.heappush(events, (arrival, camera, index, exposed))
    times = SetTimes(PERIOD // 2, period_ns=PERIOD, skew_ns=40_000)
    matcher = MatchByTime(NAMES, times)
    matched, errors, next_reading = [], [], 0
    while events:
        arrival, camera, index, exposed = heapq.heappop(events)
        while readings and arrival >= next_reading:
            for number, fit in enumerate(fits):
                to, back = (int(each) for each in random.exponential(200_000, 2))
                fit.add_reading(device[number](next_reading), next_reading - to, next_reading + back)
                estimates[number] = fit.estimate()
            next_reading += SECOND
        stamp = device[camera](exposed)
        if not readings:
            fits[camera].add_arrival(stamp, arrival)
            if index % 64 == camera:
                estimates[camera] = fits[camera].estimate()
        if (estimate := estimates[camera]) is None:
            continue
        found = estimate.host_time(stamp)
        errors.append((abs(found.time_ns - exposed), found.uncertainty_ns))
        matched += matcher.add(NAMES[camera], index, FrameStamp(*found), arrival)
    return matched + matcher.flush(), np.array(errors), matcher


@pytest.mark.parametrize("readings", [True, False], ids=["clocks read", "arrivals only"])
def test_no_set_is_mismatched_and_known_offsets_are_recovered(readings, sets=600):
    matched, errors, matcher = journey(sets, 7, readings=readings)
    assert all(len(set(each.values())) == 1 for each in matched)
    assert np.all(errors[:, 0] <= errors[:, 1])
    counts = matcher.statistics.counts()
    whole = (1 - LOSS) ** len(NAMES)
    assert counts.complete > (0.9 * whole if readings else 0.6) * sets
    assert counts.complete + counts.late + counts.incomplete <= sets
    assert np.median(errors[:, 1]) < (150_000 if readings else 1_000_000)

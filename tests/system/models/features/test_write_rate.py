"""How often the feature tree writes while a slider moves."""

import time

from patience import until
from tree_bench import number


def test_writes_are_at_most_60_a_second_and_the_last_one_is_sent(stage):
    s = stage(number("Gain"))
    begun = time.monotonic()
    s.model.write("Gain", 0.0)
    until(lambda: s.grabber.writes)  # the first is sent at once
    for step in range(1, 60):
        s.model.write("Gain", float(step))
        time.sleep(0.003)
    s.settle()
    times = [moment for _, _, moment in s.grabber.writes]
    assert s.written("Gain")[0] == 0.0
    assert s.written("Gain")[-1] == 59.0
    # One that a busy machine delayed may be close to the next: the rate counts, not each pause.
    assert 2 <= len(times) <= 60 * (times[-1] - begun) + 2
    assert s.values("Gain")[-1] == 59.0

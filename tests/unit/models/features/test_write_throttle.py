import itertools

from hypothesis import given
from hypothesis import strategies as st

from grabbergui.models.features.write_throttle import WriteThrottle


def test_the_first_write_is_due_immediately_and_the_next_an_interval_later():
    throttle = WriteThrottle(0.05)
    assert throttle.ask("Gain", 10.0) == 0
    assert throttle.waits("Gain")
    throttle.sent("Gain", 10.0)
    assert not throttle.waits("Gain")
    assert round(throttle.ask("Gain", 10.02), 9) == 0.03
    assert round(throttle.ask("Gain", 10.04), 9) == 0.01
    assert throttle.ask("Gain", 10.2) == 0


def test_another_feature_does_not_overtake_and_a_command_waits():
    throttle = WriteThrottle(0.05)
    assert throttle.barrier(10.0) == 0
    throttle.ask("Gain", 10.0)
    throttle.sent("Gain", 10.0)
    throttle.ask("Gain", 10.01)
    assert round(throttle.ask("GainAuto", 10.02), 9) == 0.03
    assert round(throttle.barrier(10.02), 9) == 0.03
    assert throttle.waiting() == ("Gain", "GainAuto")


@given(st.lists(st.tuples(st.sampled_from("ABC"), st.floats(0, 0.2)), max_size=60))
def test_writes_keep_their_order_and_their_distance(steps):
    """Whatever is asked for, sent when due: in the order of the last asking, an interval apart."""
    throttle, now = WriteThrottle(0.05), 0.0
    queue: dict[str, float] = {}
    sent: list[tuple[str, float]] = []
    for name, pause in [*steps, ("end", 10.0)]:
        for waiting, due in list(queue.items()):
            if due <= now:
                del queue[waiting]
                throttle.sent(waiting, due)
                sent.append((waiting, due))
        queue.pop(name, None)
        queue[name] = now + throttle.ask(name, now)
        assert list(queue.values()) == sorted(queue.values())
        now += pause
    for name in "ABC":
        times = [due for sender, due in sent if sender == name]
        assert all(b - a >= 0.05 - 1e-9 for a, b in itertools.pairwise(times))

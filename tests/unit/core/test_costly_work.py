"""Turns for what only computes, with clocks of our own."""

import threading

import pytest

from grabbergui import sources
from grabbergui.core.costly_work import REST, CostlyWork
from grabbergui.core.errors import RemoteProtocolError, UsageError
from grabbergui.net.tree import TreeService
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.events import Message
from grabbergui.net.yarp.os.inputs import ConnectionInfo, Request
from grabbergui.terminal import remote_terminal
from patience import PATIENCE, until


class Clock:
    """Time that passes only by work and by sleeping."""

    def __init__(self):
        self.now = 100.0
        self.slept = []

    def sleep(self, seconds):
        self.slept.append(round(seconds, 6))
        self.now += seconds

    def work(self):
        return CostlyWork(clock=lambda: self.now, work_clock=lambda: self.now, sleep=self.sleep)


def test_after_work_comes_three_times_as_much_rest_for_the_next():
    clock = Clock()
    turns = clock.work()
    for address in ("10.0.0.1", "10.0.0.2", "10.0.0.1"):
        with turns.turn(address):
            clock.now += 0.02
    assert clock.slept == [0.02 * REST] * 2, "the first waits for nobody"


def test_time_that_has_passed_counts_as_rest_and_little_work_needs_none():
    clock = Clock()
    turns = clock.work()
    with turns.turn("10.0.0.1"):
        clock.now += 0.02
    clock.now += 1.0
    for _ in range(10):
        with turns.turn("10.0.0.1"):
            clock.now += 0.001
    assert clock.slept == []


def test_work_that_fails_is_rested_from_too():
    clock = Clock()
    turns = clock.work()
    with pytest.raises(RemoteProtocolError), turns.turn("10.0.0.1"):
        clock.now += 0.02
        raise RemoteProtocolError("bad")
    with turns.turn("10.0.0.2"):
        pass
    assert clock.slept == [0.02 * REST]


def _of_another_queue(turns, address):
    """Addresses share queues by their hashes, which each process counts otherwise."""
    mine = hash(address) % len(turns._queues)
    others = (f"10.0.1.{number}" for number in range(256))
    return next(other for other in others if hash(other) % len(turns._queues) != mine)


def test_one_address_has_one_place_in_the_queue_whatever_its_connections():
    turns = CostlyWork(sleep=lambda seconds: None)
    order, begun, release = [], threading.Event(), threading.Event()

    def hold():
        with turns.turn("10.0.0.1"):
            begun.set()
            assert release.wait(PATIENCE)

    def come(address):
        with turns.turn(address):
            order.append(address)

    crowd = [threading.Thread(target=come, args=("10.0.0.1",)) for _ in range(20)]
    other = _of_another_queue(turns, "10.0.0.1")
    first, friend = threading.Thread(target=hold), threading.Thread(target=come, args=(other,))
    first.start()
    assert begun.wait(PATIENCE)
    for thread in (*crowd, friend):
        thread.start()
    queues = [queue for queue in turns._queues if queue.locked()]
    until(lambda: sum(queue.locked() for queue in turns._queues) == 2, "the friend's place")
    release.set()
    for thread in (first, *crowd, friend):
        thread.join(PATIENCE)
    assert len(order) == 21 and queues


@pytest.mark.parametrize("size", [100, 5000])
def test_only_long_requests_wait_for_a_turn(monkeypatch, size):
    clock = Clock()
    monkeypatch.setattr("grabbergui.net.yarp.os.inputs.costly_work", clock.work())
    taken = []
    turn = CostlyWork.turn
    monkeypatch.setattr(
        CostlyWork, "turn", lambda self, address: taken.append(address) or turn(self, address)
    )
    info = ConnectionInfo("/peer", "tcp", ("10.0.0.1", 5))
    for message in (Message("d", text="a" * size), Message("d", memoryview(Bottle(["a" * size]).encode()))):
        request = Request(message, info)
        assert request.bottle() is request.bottle(), "read once"
        assert request.bottle() == ["a" * size]
    assert taken == (["10.0.0.1"] * 2 if size == 5000 else [])


def test_a_request_asks_for_each_feature_once():
    camera = sources.create("sim:?width=64&height=48")
    camera.open()
    try:
        service = TreeService(camera)
        names = [feature.name for feature in camera.features()]
        assert len(service.perform("feature", *names)) == len(names)
        with pytest.raises(UsageError, match="name each feature once"):
            service.perform("feature", *names, names[0])
        service.close()
        with pytest.raises(UsageError, match="60001 characters is too long, 2000 are allowed"):
            remote_terminal(camera)("x" * 60_001)
    finally:
        camera.close()

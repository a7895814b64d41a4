"""Sockets of a program with an interval timer time out as they do without one."""

from __future__ import annotations

import signal
import socket
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import closing

import pytest

from grabbergui.core.errors import AckTimeoutError
from grabbergui.driver.gige.control_channel import ControlTiming
from grabbergui.driver.gige.control_link import ControlLink
from grabbergui.net.yarp.os import sockets
from patience import PATIENCE

if sys.platform == "win32":
    pytest.skip("Windows has no interval timers", allow_module_level=True)

TICK = 0.001
"""Shorter than every timeout of these tests; those of profilers are 0.001 to 0.01."""


@pytest.fixture
def interval_timer() -> Iterator[None]:
    """A timer that interrupts the main thread; it raises once nothing can time out any more."""
    if threading.current_thread() is not threading.main_thread():
        pytest.skip("signals are for the main thread")
    end = time.monotonic() + PATIENCE

    def tick(number: int, frame: object) -> None:
        if time.monotonic() > end:
            signal.setitimer(signal.ITIMER_REAL, 0)
            raise AssertionError("the timeout never came")

    before = signal.signal(signal.SIGALRM, tick)
    signal.setitimer(signal.ITIMER_REAL, TICK, TICK)
    yield
    signal.setitimer(signal.ITIMER_REAL, 0)
    signal.signal(signal.SIGALRM, before)


@pytest.fixture
def pair() -> Iterator[tuple[socket.socket, socket.socket]]:
    """Both ends of a connection; ours has a timeout."""
    ours, theirs = socket.socketpair()
    with ours, theirs:
        sockets.set_deadline(ours, 0.05)
        yield ours, theirs


def test_a_camera_that_does_not_answer_times_out(interval_timer: None) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as silent:
        silent.bind(("127.27.0.9", 0))
        link = ControlLink(*silent.getsockname(), ControlTiming(ack_timeout=0.05, tries=2))
        with closing(link), pytest.raises(AckTimeoutError):
            link.read_register(0)


def test_a_port_that_sends_nothing_times_out(
    interval_timer: None, pair: tuple[socket.socket, socket.socket]
) -> None:
    ours, theirs = pair
    for size in (4, 4 * sockets._WAKE_BYTES):
        with pytest.raises(AckTimeoutError):
            sockets.receive_body(ours, memoryview(bytearray(size)))
    with pytest.raises(AckTimeoutError):
        sockets.receive(ours, 4)
    theirs.send(b"1234")
    assert sockets.receive_exactly(ours, 4) == b"1234"


def test_a_port_that_reads_nothing_times_out(
    interval_timer: None, pair: tuple[socket.socket, socket.socket]
) -> None:
    with pytest.raises(AckTimeoutError):
        sockets.send(pair[0], [bytes(1 << 24)])


def test_without_a_timeout_there_is_none(
    interval_timer: None, pair: tuple[socket.socket, socket.socket]
) -> None:
    ours, theirs = pair
    sockets.set_deadline(ours, None)
    later = threading.Timer(3 * TICK, theirs.send, (b"x",))
    later.start()
    assert sockets.receive(ours, 1) == b"x"
    later.join()


def test_a_closed_socket_is_a_connection_error(
    interval_timer: None, pair: tuple[socket.socket, socket.socket]
) -> None:
    pair[0].close()
    with pytest.raises(sockets.TransportError, match="the connection broke"):
        sockets.receive(pair[0], 1)

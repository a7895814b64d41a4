"""A server that was killed seems to be there for 20 s more: who asks it waits once, and nobody else does."""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace
from typing import Any

import pytest

from grabbergui.core.errors import DeviceLostError, FrameTimeoutError
from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.core.grabber import ConnectionState
from grabbergui.net.ros2 import client, client_link
from grabbergui.net.ros2.client import Ros2Grabber
from grabbergui.net.ros2.client_link import CameraLink, Publisher
from patience import PATIENCE, attempts


class Service:
    """A client of a service that is listed; it answers while `answering`."""

    srv_name = "/cam/ask"
    answering = True

    def service_is_ready(self) -> bool:
        return True

    def call_async(self, request: Any) -> Any:
        answered = self.answering
        return SimpleNamespace(
            done=lambda: answered,
            result=lambda: request,
            add_done_callback=lambda call: call(None) if answered else None,
        )

    def remove_pending_request(self, future: Any) -> None:
        pass


@pytest.fixture
def link(monkeypatch: pytest.MonkeyPatch) -> CameraLink:
    monkeypatch.setattr(client_link, "CALL_TIMEOUT", 0.5)
    monkeypatch.setattr(client_link, "POLL_TIMEOUT", 0.02)
    monkeypatch.setattr(client_link, "_LOOK_PERIOD", 0.005)
    publisher = Publisher("/cam", client_link.IMAGE_TYPE, reliable=True, durable=False)
    return CameraLink(None, "/cam/image_raw", publisher, threading.Event())


def seconds_of(link: CameraLink, service: Service) -> float:
    begun = time.monotonic()
    with pytest.raises(FrameTimeoutError):
        link._wait(service, "request", client_link.CALL_TIMEOUT)
    return time.monotonic() - begun


def test_a_service_that_fell_silent_is_waited_for_at_length_only_once(link: CameraLink) -> None:
    service = Service()
    assert link._wait(service, "request") == "request"
    service.answering = False
    assert seconds_of(link, service) >= 0.5
    assert min(seconds_of(link, service) for _ in range(5)) < 0.4
    service.answering = True
    assert link._wait(service, "request") == "request"
    service.answering = False
    assert seconds_of(link, service) >= 0.5, "it had answered again"


def test_closing_ends_the_wait_for_an_answer(link: CameraLink, monkeypatch: pytest.MonkeyPatch) -> None:
    service, asked = Service(), threading.Event()

    def ready(self: Service) -> bool:
        asked.set()
        return True

    monkeypatch.setattr(Service, "answering", False)
    monkeypatch.setattr(Service, "service_is_ready", ready)
    with ThreadPoolExecutor() as pool:
        for watch in attempts(0.2):
            link._closing.clear()
            asked.clear()
            waiting = pool.submit(link._wait, service, "request", PATIENCE)
            assert asked.wait(PATIENCE)
            with watch:
                link._closing.set()
                assert isinstance(waiting.exception(PATIENCE), DeviceLostError)


def test_a_stream_is_stopped_while_a_feature_is_waited_for() -> None:
    grabber = Ros2Grabber("/cam")
    closed = threading.Event()
    grabber._stream = SimpleNamespace(close=closed.set, statistics=StreamStatistics)  # type: ignore[assignment]
    held, over = threading.Event(), threading.Event()

    def wait_for_a_feature() -> None:
        with grabber._lock:
            held.set()
            over.wait(PATIENCE)

    waiting = threading.Thread(target=wait_for_a_feature)
    waiting.start()
    assert held.wait(PATIENCE)
    try:
        for watch in attempts(0.2):
            with watch:
                grabber.stop()
        assert closed.is_set() and not grabber.streaming
    finally:
        over.set()
        waiting.join()


def test_the_first_answer_to_a_poll_may_be_as_late_as_any(link: CameraLink) -> None:
    """A lost packet is sent again after seconds; opening asks `hello` after it has asked for the tree."""
    pytest.importorskip("grabber_interfaces", reason="the interface package is not built: make setup-ros2")

    class Late(Service):
        def call_async(self, request: Any) -> Any:
            arrived = threading.Event()
            answer = SimpleNamespace(success=True, result="{}")
            return SimpleNamespace(
                done=arrived.is_set,
                result=lambda: answer,
                add_done_callback=lambda call: threading.Timer(
                    0.1, lambda: (arrived.set(), call(None))
                ).start(),
            )

    link._clients["ask"] = Late()
    assert [link._ask(verb) for verb in ("tree", "hello")] == [{}, {}]
    with pytest.raises(FrameTimeoutError, match=r"within 0.02 s"):
        link._ask("hello")


def test_a_killed_server_is_missed_within_a_second_and_its_successor_is_no_second_sender(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """DDS lists the killed one for 20 s more. A frame waits 5 s, so what waits for one learns of the loss."""
    pytest.importorskip("grabber_interfaces", reason="the interface package is not built: make setup-ros2")
    monkeypatch.setattr(client, "OVERDUE", 0.7)  # as for users
    served = [
        sys.executable,
        "-m",
        "grabbergui",
        "serve",
        "sim:?width=64&height=48&fps=50",
        "--ros2",
        "/doomed",
    ]
    notices: list[str] = []
    servers = [subprocess.Popen(served, stdout=subprocess.PIPE, text=True)]
    grabber = Ros2Grabber("/doomed")
    try:
        assert servers[0].stdout is not None
        # Programs start slowly on a busy machine, and opening waits for 20 s at most.
        assert any("/doomed" in line for line in servers[0].stdout), "it serves"
        grabber.open()
        grabber.noticed.connect(notices.append)
        frames = grabber.open_queue(1)
        grabber.start()
        frames.get(PATIENCE)
        lost, back = threading.Event(), threading.Event()
        grabber.connection_changed.connect(
            lambda state, _: (lost if state is ConnectionState.LOST else back).set()
        )
        for watch in attempts(1.0):
            frames.get(PATIENCE)
            lost.clear()
            back.clear()
            servers[-1].kill()
            with watch:
                assert lost.wait(PATIENCE)
            servers.append(subprocess.Popen(served))
            assert back.wait(PATIENCE)
        looks = grabber.statistics().frames + 100
        while grabber.statistics().frames < looks:
            frames.get(PATIENCE)
        assert not [notice for notice in notices if "mix" in notice]
    finally:
        grabber.close()
        for server in servers:
            server.kill()
            server.communicate()

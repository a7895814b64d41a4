"""A remote camera that goes away and comes back, with its server or alone."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest

from grabber_stage import Stage, connect, pretend_to_be_yarps_own
from grabbergui.core.errors import (
    DeviceLostError,
    RemoteProtocolError,
    SourceUnavailableError,
    TransportError,
)
from grabbergui.core.grabber import ConnectionState
from grabbergui.core.settings import SettingKey
from grabbergui.net.tree import TreeFeatures
from grabbergui.net.yarp import grabber_link, grabber_service, grabber_values
from grabbergui.net.yarp.client import YarpGrabber
from grabbergui.net.yarp.client_stream import ImageStream
from grabbergui.net.yarp.os import carrier, name_client
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.outputs import connect as connect_output
from grabbergui.net.yarp.os.values import Vocab
from patience import PATIENCE, attempts, until


def test_the_server_goes_and_comes_back(scene: Stage) -> None:
    states: list[ConnectionState] = []
    server = scene.share()
    server.start()
    remote = connect(scene)
    remote.connection_changed.connect(lambda state, reason: states.append(state))
    remote.open()
    queue = remote.open_queue(1)
    remote.start()
    queue.get(PATIENCE)
    server.stop()
    until(lambda: ConnectionState.LOST in states, "the loss")
    with pytest.raises(TransportError):
        remote.feature("Gain")
    assert remote.has_feature("Gain")  # what was known stays known
    queue.clear()
    with scene.share():
        until(lambda: states[-1] is ConnectionState.OPEN, "the return")
        assert queue.get(PATIENCE).complete
        assert remote.feature("Gain").value is not None
        remote.close()
    assert states == [
        *(ConnectionState.OPEN, ConnectionState.LOST, ConnectionState.OPEN, ConnectionState.CLOSED),
    ]


def test_a_server_that_hangs_is_waited_for_once(scene: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    """As one whose machine lost its power, or that was stopped in a debugger."""
    answering = threading.Event()
    answering.set()
    answer = grabber_service.GrabberService.answer

    def hang(self: grabber_service.GrabberService, request: Bottle) -> Bottle:
        answering.wait(PATIENCE)
        return answer(self, request)

    monkeypatch.setattr(grabber_service.GrabberService, "answer", hang)
    with scene.share():
        remote = connect(scene)
        remote.open()
        monkeypatch.setattr(grabber_link, "TREE_TIMEOUT", 0.2)
        monkeypatch.setattr(grabber_link, "TIMEOUT", PATIENCE)
        answering.clear()
        try:
            with pytest.raises(TransportError):
                remote.feature("Gain")
            with pytest.raises(DeviceLostError, match="is not available"):
                remote.feature("Gain")
            until(lambda: bool(remote.lost), "the loss")
            with pytest.raises(DeviceLostError, match="not available"):  # while the watcher connects
                remote.feature("Gain")
            remote.stop()
        finally:
            answering.set()
        until(lambda: not remote.lost, "the return")
        assert remote.feature("Gain").value is not None
        remote.close()


def test_closing_does_not_wait_for_a_server_that_hangs(scene: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    """A request that waits for its answer ends, and nothing is reported as lost."""
    hanging, going = threading.Event(), threading.Event()
    going.set()
    answer = grabber_service.GrabberService.answer

    def hang(self: grabber_service.GrabberService, request: Bottle) -> Bottle:
        if not going.is_set():
            hanging.set()
        going.wait(PATIENCE)
        return answer(self, request)

    monkeypatch.setattr(grabber_service.GrabberService, "answer", hang)
    monkeypatch.setattr(grabber_link, "TREE_TIMEOUT", PATIENCE)
    states: list[ConnectionState] = []
    remote = connect(scene)
    remote.connection_changed.connect(lambda state, reason: states.append(state))
    with scene.share(), ThreadPoolExecutor() as pool:
        for watch in attempts(0.5):
            remote.open()
            remote.start()
            states.clear()
            hanging.clear()
            going.clear()
            try:
                reading = pool.submit(remote.feature, "Gain")
                assert hanging.wait(PATIENCE)
                with watch:
                    remote.close()
                assert isinstance(reading.exception(PATIENCE), TransportError)
                assert states == [ConnectionState.CLOSED] and not remote.lost
            finally:
                going.set()


def test_closing_does_not_wait_for_a_name_server_that_hangs(scene: Stage) -> None:
    """Another thread waits for it, to start the stream."""
    asked, over = threading.Event(), threading.Event()

    def hang(self: name_client.NameClient, command: str) -> list[str]:
        asked.set()
        over.wait(PATIENCE)
        raise SourceUnavailableError("no YARP name server")

    remote = connect(scene)
    with scene.share(), ThreadPoolExecutor() as pool:
        for watch in attempts(0.5):
            remote.open()
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(name_client.NameClient, "ask", hang)
                asked.clear()
                over.clear()
                starting = pool.submit(remote.start)
                assert asked.wait(PATIENCE)
                with watch:
                    remote.close()
                over.set()
                assert isinstance(starting.exception(PATIENCE), SourceUnavailableError)
        remote.open()
        assert remote.feature("Gain").value is not None and not remote.streaming
        remote.close()


def test_a_camera_that_was_closed_while_it_was_lost_is_not_lost_when_it_is_opened_again(scene: Stage) -> None:
    remote = connect(scene)
    with scene.share():
        remote.open()
    until(lambda: bool(remote.lost), "the loss")
    remote.close()
    with scene.share():
        remote.open()
        assert not remote.lost
        remote.close()


def test_a_name_server_that_ends_loses_nothing_that_is_open(
    scene: Stage, monkeypatch: pytest.MonkeyPatch
) -> None:
    states: list[ConnectionState] = []
    asked: list[str] = []

    def no_answer(self: name_client.NameClient, prefix: str = "") -> None:
        asked.append(prefix)
        raise SourceUnavailableError("no YARP name server")

    with scene.share():
        remote = connect(scene)
        remote.open()
        remote.connection_changed.connect(lambda state, reason: states.append(state))
        monkeypatch.setattr(name_client.NameClient, "list", no_answer)
        remote.start()
        until(lambda: len(asked) > 1, "two searches for components")
        assert states == [] and remote.open_queue(1).get(PATIENCE).complete
        remote.close()


def test_a_stream_that_is_started_while_the_server_is_away_starts_when_it_is_back(scene: Stage) -> None:
    """As after a file of settings whose loading the loss broke off, with the stream paused for it."""
    states: list[ConnectionState] = []
    remote = connect(scene)
    with scene.share():
        remote.connection_changed.connect(lambda state, reason: states.append(state))
        remote.open()
    until(lambda: ConnectionState.LOST in states, "the loss")
    with pytest.raises(DeviceLostError):
        remote.start()
    with scene.share():
        queue = remote.open_queue(1)
        until(lambda: states[-1] is ConnectionState.OPEN, "the return")
        assert remote.streaming and queue.get(PATIENCE).complete
        remote.close()


def test_a_stream_whose_first_start_on_the_return_fails_starts_at_the_next_attempt(
    scene: Stage, monkeypatch: pytest.MonkeyPatch
) -> None:
    states: list[ConnectionState] = []
    remote = connect(scene)
    with scene.share():
        remote.connection_changed.connect(lambda state, reason: states.append(state))
        remote.open()
    until(lambda: ConnectionState.LOST in states, "the loss")
    with pytest.raises(DeviceLostError):
        remote.start()
    tries: list[object] = []
    start = ImageStream.open

    def refused_once(self: ImageStream) -> None:
        tries.append(self)
        if len(tries) == 1:
            raise TransportError("the port for images is not there yet")
        start(self)

    monkeypatch.setattr(ImageStream, "open", refused_once)
    with scene.share():
        queue = remote.open_queue(1)
        until(lambda: states[-1] is ConnectionState.OPEN, "the return")
        assert remote.streaming and queue.get(PATIENCE).complete
        remote.close()
    assert len(tries) == 2


def test_a_server_that_is_back_with_other_values_reports_it(
    coloured: Stage, caplog: pytest.LogCaptureFixture
) -> None:
    reported: list[tuple[ConnectionState, str]] = []
    with coloured.share():
        remote = connect(coloured)
        remote.connection_changed.connect(lambda state, why: reported.append((state, why)))
        remote.open()
        before = remote.write_feature("Gain", 3.0).value
        red = SettingKey("BalanceRatio", (("BalanceRatioSelector", "Red"),))
        remote.write_setting(red, 1.5)
        remote.read_setting(red)
    until(lambda: reported[-1][0] is ConnectionState.LOST, "the loss")
    coloured.grabber.write_feature("Gain", 0.0)
    coloured.grabber.write_setting(red, 1.25)
    with coloured.share():
        until(lambda: reported[-1][0] is ConnectionState.OPEN, "the return")
        assert before == 3.0
        expected = ("Gain is 0 instead of 3", f"{red} is 1.25 instead of 1.5")
        assert remote.unlike_before == expected
        assert all(difference in caplog.text for difference in expected), "for commands, which show the log"
        assert reported[-1][1] == f"but not as before: {'; '.join(expected)}"
        remote.close()


def test_a_server_that_answers_nonsense_on_its_return_is_back_once_it_answers(
    scene: Stage, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing else shows that one of YARP's own servers is back."""
    pretend_to_be_yarps_own(monkeypatch, "3.x")
    states: list[ConnectionState] = []
    with scene.share():
        remote = connect(scene)
        remote.open()
        remote.connection_changed.connect(lambda state, reason: states.append(state))
        remote.feature("Gain")
    until(lambda: states, "the loss")
    tries: list[object] = []
    compare = YarpGrabber._compare_with_seen

    def garbled(self: YarpGrabber) -> None:
        tries.append(self)
        if len(tries) < 3:
            raise RemoteProtocolError("a Bottle ends in the middle")
        compare(self)

    monkeypatch.setattr(YarpGrabber, "_compare_with_seen", garbled)
    with scene.share():
        until(lambda: states[-1] is ConnectionState.OPEN, "the return")
        remote.close()
    assert len(tries) == 3


def test_a_server_that_only_answers_nonsense_is_logged_once(
    scene: Stage, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    looks: list[object] = []

    def garbled(self: object) -> None:
        looks.append(self)
        raise RemoteProtocolError("a Bottle ends in the middle")

    with scene.share():
        remote = connect(scene)
        remote.open()
        monkeypatch.setattr(TreeFeatures, "look", garbled)
        until(lambda: len(looks) > 5, "several looks")
        assert caplog.text.count("ends in the middle") == 1
        monkeypatch.undo()
        remote.close()


def test_a_server_that_vanished_without_closing_its_connections_is_read_again(scene: Stage) -> None:
    lost = threading.Event()
    remote = connect(scene)
    with scene.share():
        remote.connection_changed.connect(lambda state, why: state is ConnectionState.LOST and lost.set())
        remote.open()
        queue = remote.open_queue(1)
        remote.start()
        queue.get(PATIENCE)
    assert lost.wait(PATIENCE)
    ours = next(contact for contact in scene.names.list("/grabbergui/") if contact.name.endswith("/grabber"))
    # What a server's machine that loses its power leaves behind: a connection that says nothing any more.
    dead = connect_output(
        "/grabber", "/grabber", ours.name, ours.address, carrier.FAST_TCP, None, pytest.fail
    )[0]
    assert isinstance(remote, YarpGrabber) and remote._stream is not None
    until(lambda: remote._stream.connected, "the dead connection")
    queue.clear()
    with scene.share():
        assert queue.get(PATIENCE).complete
        remote.close()
    dead.close()


def test_a_server_that_has_no_camera_yet(scene: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    answer = grabber_service.GrabberService.answer
    empty = [Bottle([Vocab("fail")]).encode()]
    monkeypatch.setattr(grabber_service.GrabberService, "answer", lambda self, message: empty)
    with scene.share():
        remote = connect(scene)
        remote.open()
        assert not remote.has_feature("Gain")
        states: list[ConnectionState] = []
        remote.connection_changed.connect(lambda state, reason: states.append(state))

        def attached(self: grabber_service.GrabberService, message: Bottle) -> object:
            return empty if isinstance(message[0], str) else answer(self, message)

        monkeypatch.setattr(grabber_service.GrabberService, "answer", attached)
        until(lambda: states, "the camera's arrival")
        assert remote.has_feature("Gain")
        remote.close()


def test_another_camera_on_the_port_is_refused_and_named_until_the_same_is_back(
    scene: Stage, monkeypatch: pytest.MonkeyPatch
) -> None:
    read_hello = grabber_values.read_tree_hello
    reported: list[tuple[ConnectionState, str]] = []
    with scene.share():
        remote = connect(scene)
        remote.open()
        remote.connection_changed.connect(lambda state, reason: reported.append((state, reason)))
    until(lambda: reported)
    other = replace(scene.grabber.info, serial="OTHER")
    monkeypatch.setattr(grabber_values, "read_tree_hello", lambda reply: other)
    with scene.share():
        until(lambda: "OTHER" in reported[-1][1])
        assert reported[-1][0] is ConnectionState.LOST
        monkeypatch.setattr(grabber_values, "read_tree_hello", read_hello)
        until(lambda: reported[-1][0] is ConnectionState.OPEN)
        assert sum("OTHER" in reason for _, reason in reported) == 1, "said once, not at every attempt"
        assert remote.info.serial == scene.grabber.info.serial
        remote.close()

"""The shared camera as its readers see it, over sockets."""

from __future__ import annotations

import os
import socket
import struct
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from types import SimpleNamespace

import numpy as np
import pytest

from fakes import ScriptedGrabber
from grabber_stage import Stage
from grabbergui.core.errors import SourceUnavailableError, TransportError
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import by_name
from grabbergui.core.scheduling import realtime_threads_permitted
from grabbergui.net.component_joiner import MOST_COMPONENTS
from grabbergui.net.yarp import grabber_service, image
from grabbergui.net.yarp import server as server_module
from grabbergui.net.yarp.grabber_image import Capability
from grabbergui.net.yarp.grabber_rpc import VERSION_REPLY
from grabbergui.net.yarp.os import carrier, port
from grabbergui.net.yarp.os.binary import encode_message
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.carrier import encode_header
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.ports import InputPort
from grabbergui.net.yarp.os.rpc_client import RpcClient
from grabbergui.net.yarp.os.stamp import Stamp
from grabbergui.net.yarp.os.values import Vocab
from grabbergui.net.yarp.server import YarpGrabberServer
from patience import PATIENCE, attempts, until
from yarp_bytes import reply_to


@pytest.fixture
def server(scene: Stage) -> Iterator[YarpGrabberServer]:
    with scene.share(also_raw=True) as server:
        yield server


def test_its_ports_are_known_while_it_runs(scene: Stage, server: YarpGrabberServer) -> None:
    assert {"/grabber", "/grabber/raw", "/grabber/rpc"} <= {contact.name for contact in scene.names.list()}
    assert scene.grabber.streaming
    server.stop()
    server.stop()
    assert not {c.name for c in scene.names.list()} & {"/grabber", "/grabber/raw", "/grabber/rpc"}
    assert not scene.grabber.streaming


@pytest.mark.parametrize("chosen", ["tcp", "fast_tcp", "udp", "mjpeg"])
def test_images_over_each_carrier(scene: Stage, server: YarpGrabberServer, chosen: str) -> None:
    begun = time.time()
    with InputPort("/reader", scene.names) as reader:
        reader.connect("/grabber", chosen)
        message, envelope = reader.read(PATIENCE)
        header, pixels = image.decode(message)
        assert (header.code, pixels.shape) == ("rgb", (100, 168, 3))
        first = Stamp.decode(envelope)
        second = Stamp.decode(reader.read(PATIENCE)[1])
        assert first and second and second.count > first.count
        assert begun - 5 < second.time < time.time() + 5


def test_raw_images_are_on_a_port_of_their_own(scene: Stage, server: YarpGrabberServer) -> None:
    with InputPort("/reader", scene.names) as reader:
        reader.connect("/grabber/raw")
        header, pixels = image.decode(reader.read(PATIENCE)[0])
        assert (header.code, pixels.shape) == ("mono", (100, 168))


def test_a_reader_may_ask_for_mono_beside_others(scene: Stage, server: YarpGrabberServer) -> None:
    with InputPort("/reader", scene.names) as asking, InputPort("/viewer", scene.names) as other:
        asking.connect("/grabber", "fast_tcp+pixels.mono")
        other.connect("/grabber", "fast_tcp")
        for _ in range(2):
            header, pixels = image.decode(asking.read(PATIENCE)[0])
            assert (header.code, pixels.shape) == ("mono", (100, 168))
            header, colour = image.decode(other.read(PATIENCE)[0])
            assert (header.code, colour.shape) == ("rgb", (100, 168, 3))


def test_both_layouts_show_the_same_frame(scene: Stage) -> None:
    queue = scene.grabber.open_queue(1)
    with scene.share():
        frame = queue.get(PATIENCE)
    queue.close()
    grey, code = Capability.COLOR.pixels(frame, mono=True)
    assert code == "mono" and np.array_equal(frame.rgb(), np.dstack([grey] * 3))


def test_raw_images_instead_of_colour(scene: Stage) -> None:
    with scene.share(capabilities=Capability.RAW), InputPort("/reader", scene.names) as reader:
        reader.connect("/grabber")
        assert image.decode(reader.read(PATIENCE)[0])[0].code == "mono"


def test_a_period_spaces_images(scene: Stage) -> None:
    with scene.share(period=0.2), InputPort("/reader", scene.names, depth=10) as reader:
        reader.connect("/grabber")
        times = [Stamp.decode(reader.read(PATIENCE)[1]) for _ in range(4)]
        stamps = [stamp.time for stamp in times if stamp]
        assert stamps[-1] - stamps[0] > 0.5


def test_a_period_keeps_its_rate_though_frames_come_at_other_times(monkeypatch: pytest.MonkeyPatch) -> None:
    now, sent = 100.0, []
    port = SimpleNamespace(
        name="/out",
        connections=1,
        asked_for=lambda modifier: {""},
        write=lambda *parts, only: sent.append(round(now - 100.0, 2)),
    )
    monkeypatch.setattr(server_module.time, "monotonic", lambda: now)
    publisher = server_module._Publisher(ScriptedGrabber(), port, Capability.COLOR, 0.1)
    frame = Frame(np.zeros(1, np.uint8), 1, 1, by_name("Mono8"))
    for number in range(11):
        now = 100.0 + 0.06 * number
        publisher._offer(frame)
    assert sent == [0.0, 0.12, 0.24, 0.3, 0.42, 0.54, 0.6]
    now = 110.0
    for _ in range(5):  # what was missed in a pause is not made up for
        publisher._offer(frame)
    assert sent[7:] == [10.0]


def test_without_readers_no_image_is_converted(
    scene: Stage, server: YarpGrabberServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    converted: list[object] = []
    monkeypatch.setattr(Capability, "encode", lambda self, frame: converted.append(frame))
    queue = scene.grabber.open_queue(3)
    for _ in range(3):
        queue.get(PATIENCE)
    queue.close()
    assert converted == []
    assert server.published == 0


def test_a_camera_polls_no_features_for_readers_of_images(scene: Stage, server: YarpGrabberServer) -> None:
    """They took a twentieth of the server's time."""
    with InputPort("/reader", scene.names) as reader:
        reader.connect("/grabber")
        reader.read(PATIENCE)
        assert not len(scene.grabber.features_changed), "it polls for listeners"


@pytest.mark.skipif(sys.platform != "linux", reason="priorities are Linux's")
def test_frames_are_sent_on_with_realtime_priority_if_permitted(
    scene: Stage, server: YarpGrabberServer
) -> None:
    if not realtime_threads_permitted():
        pytest.skip("real-time priority is not permitted")
    wanted, found = {"yarp /grabber images", "yarp /grabber to /reader"}, set()

    def all_have_it() -> bool:
        for thread in threading.enumerate():
            with suppress(ProcessLookupError):
                policy = os.sched_getscheduler(thread.native_id or 0) & ~os.SCHED_RESET_ON_FORK
                if policy == os.SCHED_RR:
                    found.add(thread.name)
        return wanted <= found

    with InputPort("/reader", scene.names) as reader:
        reader.connect("/grabber")
        until(all_have_it, "real-time priority")


def test_a_stuck_reader_slows_nobody(scene: Stage, server: YarpGrabberServer) -> None:
    with InputPort("/reader", scene.names) as reader:
        stuck = _reverse_reader(scene, "/stuck")
        try:
            reader.connect("/grabber")
            until(lambda: server.readers == 2, "both readers' connection")
            before = server.published
            for _ in range(20):  # far more than would fit between it and the stuck one
                reader.read(PATIENCE)
            assert server.published - before >= 19
        finally:
            stuck.close()


def _reverse_reader(scene: Stage, name: str) -> socket.socket:
    """Asks for the stream over tcp and then neither reads nor acknowledges."""
    sock = socket.create_connection(scene.names.query("/grabber").address, 5)
    sock.sendall(encode_header(carrier.TCP, name))
    sock.sendall(b"".join(encode_message("r")))
    return sock


def test_requests_on_either_port(scene: Stage, server: YarpGrabberServer) -> None:
    for name in ("/grabber/rpc", "/grabber"):
        with RpcClient(name, scene.names) as rpc:
            reply = rpc.call(Bottle.from_text("[fgc] [set] [feat] 8 5"))
            assert reply is not None
            assert reply.to_text() == "[fgc] [set] 1"
            version = Bottle(["getRemoteProtocolVersion"]).encode()
            assert reply_to(scene.names.query(name).address, version) == VERSION_REPLY
            # Both dialects on one connection.
            assert rpc.call(Bottle(["getWidthRPC"])) == [[Vocab("ok")], 168]


def test_a_round_trip_waits_for_nothing(scene: Stage, server: YarpGrabberServer) -> None:
    with RpcClient("/grabber/rpc", scene.names) as rpc:
        request = Bottle.from_text("[fgc] [get] [feat] 8")
        for watch in attempts(100 * 5e-3):  # a wait for a delayed acknowledge takes 40 ms each
            with watch:
                replies = [rpc.call(request) for _ in range(100)]
            assert len({str(reply) for reply in replies}) == 1 and "[fail]" not in str(replies[0])


def test_malformed_requests_are_refused(scene: Stage, server: YarpGrabberServer) -> None:
    address = scene.names.query("/grabber/rpc").address
    claims = struct.pack("<iii", 256, 2**31 - 1, 1)
    for body in (claims, b"\xff" * 40, struct.pack("<ii", 256 + 1, -1)):
        with socket.create_connection(address, 5) as sock:
            sock.settimeout(5)
            sock.sendall(encode_header(carrier.FAST_TCP, "/bad"))
            sock.sendall(b"".join(encode_message("d", [body])))
            assert len(sock.recv(8)) == 8  # the greeting's answer
            assert b"fail" in sock.recv(4096)
    with RpcClient("/grabber/rpc", scene.names) as rpc:
        assert rpc.call(Bottle(["getWidthRPC"]))


def test_a_request_that_waits_for_a_frame_does_not_hold_up_the_end(
    scene: Stage, monkeypatch: pytest.MonkeyPatch
) -> None:
    waiting = threading.Event()
    monkeypatch.setattr(grabber_service, "frame_wait", lambda *_: waiting.set() or PATIENCE)
    monkeypatch.setattr(port, "END_SECONDS", PATIENCE)
    server = scene.share()
    server.start()
    scene.grabber.stop()
    with RpcClient("/grabber/rpc", scene.names) as rpc, ThreadPoolExecutor(1) as pool:
        asking = pool.submit(rpc.call, Bottle.from_text("fgi get imgr"), PATIENCE)
        assert waiting.wait(PATIENCE)
        begun = time.monotonic()
        server.stop()
        assert time.monotonic() - begun < PATIENCE / 2
        assert asking.exception(PATIENCE) or asking.result()[0] == Vocab("fail")


def test_a_hundred_clients_at_once(scene: Stage, server: YarpGrabberServer) -> None:
    answers: list[object] = []

    def ask() -> None:
        with RpcClient("/grabber/rpc", scene.names) as rpc:
            answers.append(rpc.call(Bottle(["getWidthRPC"]), 10))

    threads = [threading.Thread(target=ask) for _ in range(100)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(PATIENCE)
    assert len([answer for answer in answers if answer]) == 100


def test_without_a_name_server_nothing_is_left(scene: Stage) -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        names = NameClient.find(f"127.0.0.1:{free.getsockname()[1]}")
        threads = threading.active_count()
        with pytest.raises(SourceUnavailableError):
            YarpGrabberServer(scene.grabber, names=names).start()
        with pytest.raises(TransportError, match="listen"):
            YarpGrabberServer(scene.grabber, names=scene.names, bind="203.0.113.7").start()
    until(lambda: threading.active_count() <= threads, "the threads' end")
    assert not scene.grabber.streaming


def test_a_camera_that_does_not_start_leaves_no_port_open(scene: Stage) -> None:
    class Refusing(ScriptedGrabber):
        def start(self, *, keep_trigger: bool = False) -> None:
            raise TransportError("no bandwidth")

    threads = threading.active_count()
    server = YarpGrabberServer(Refusing(), "/refusing", names=scene.names)
    with pytest.raises(TransportError, match="no bandwidth"):
        server.start()
    assert not [name for name in scene.names.list() if name.name.startswith("/refusing")]
    until(lambda: threading.active_count() <= threads, "the threads' end")


def test_there_are_no_more_ports_of_components_than_allowed_and_none_once_it_is_stopped() -> None:
    opened: list[str] = []

    def make_port(name: str) -> SimpleNamespace:
        return SimpleNamespace(open=lambda: opened.append(name), close=lambda: opened.remove(name), place=str)

    components = server_module.ComponentPorts(ScriptedGrabber(), "/cam", make_port)
    ports = [components._port(f"part{number}") for number in range(MOST_COMPONENTS + 3)]
    assert [port is not None for port in ports] == [True] * MOST_COMPONENTS + [False] * 3
    assert len(opened) == len(components.ports) == MOST_COMPONENTS and components._port("part0") is ports[0]
    components.stop()
    components.stop()
    assert (opened, components.ports) == ([], ())


def test_requests_to_the_terminal_port_are_lines_of_the_terminal(
    scene: Stage, server: YarpGrabberServer
) -> None:
    with RpcClient("/grabber/terminal", scene.names) as terminal:
        reply = terminal.call(Bottle(["set_feature", "Gain", 2]), 5)
        assert reply and str(reply[0]).startswith("Gain = 2 dB")
        refused = terminal.call(Bottle(["get_feature", "Warp"]), 5)
        assert refused and refused[0] == "fail" and "no feature Warp" in str(refused[1])
        listed = terminal.call(Bottle(["list_features", "Gain"]), 5)
        assert listed and len(listed) > 1


@pytest.mark.parametrize("text", ["Bob's", "two  blanks", "", "#1"])
def test_a_text_is_one_word_for_the_terminal(scene: Stage, server: YarpGrabberServer, text: str) -> None:
    with RpcClient("/grabber/terminal", scene.names) as terminal:
        terminal.call(Bottle(["set", "DeviceUserID", text]), 5)
        assert scene.grabber.feature("DeviceUserID").value == text
        terminal.call(Bottle(["set DeviceUserID whole"]), 5)
        assert scene.grabber.feature("DeviceUserID").value == "whole"


def test_a_server_that_was_given_no_terminal_reports_it(scene: Stage) -> None:
    with (
        YarpGrabberServer(scene.grabber, "/mute", names=scene.names),
        RpcClient("/mute/terminal", scene.names) as terminal,
    ):
        refused = terminal.call(Bottle(["stats"]), 5)
        assert refused and refused[0] == "fail" and "no terminal" in str(refused[1])


def test_a_range_image_is_on_a_port_of_its_own_in_metres(scene: Stage) -> None:
    scene.grabber.write_feature("ComponentSelector", "Range")
    scene.grabber.write_feature("ComponentEnable", True)
    try:
        with scene.share(), InputPort("/reader", scene.names) as reader:
            until(lambda: "/grabber/range" in {contact.name for contact in scene.names.list()})
            reader.connect("/grabber/range")
            message, envelope = reader.read(PATIENCE)
            header, pixels = image.decode(message)
            assert (header.code, pixels.shape, pixels.dtype) == ("dec", (100, 168), np.float32)
            assert 0.55 < np.nanmin(pixels) < np.nanmax(pixels) < 1.5
            assert Stamp.decode(envelope)
            with InputPort("/other", scene.names) as other:
                other.connect("/grabber")
                assert image.decode(other.read(PATIENCE)[0])[0].code == "rgb"
        assert "/grabber/range" not in {contact.name for contact in scene.names.list()}
    finally:
        scene.grabber.write_feature("ComponentSelector", "Range")
        scene.grabber.write_feature("ComponentEnable", False)


def test_a_slash_at_the_end_of_the_name_is_left_out(scene: Stage) -> None:
    with YarpGrabberServer(scene.grabber, "/slashed/", names=scene.names) as server:
        assert server.name == "/slashed"
        found = {contact.name for contact in scene.names.list("/slashed")}
    assert found == {"/slashed", "/slashed/rpc", "/slashed/terminal"}

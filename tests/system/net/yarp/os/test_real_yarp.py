"""Our ports and name server under the hands of YARP's own tools, any version, where they are on the PATH."""

import os
import shutil
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager

import numpy as np
import pytest

from grabbergui.net.yarp import image
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.name_server import NameServer
from grabbergui.net.yarp.os.ports import InputPort, OutputPort, RpcServer
from grabbergui.net.yarp.os.stamp import Stamp
from grabbergui.net.yarp.os.values import Vocab
from isolation import enter_own_namespaces
from listening import listens
from patience import PATIENCE, until

pytestmark = [
    pytest.mark.yarp,
    pytest.mark.skipif(not shutil.which("yarp"), reason="needs YARP's `yarp` on the PATH"),
]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The folder of YARP's configuration."""
    monkeypatch.setenv("YARP_CONFIG_HOME", str(tmp_path))
    monkeypatch.setenv("YARP_FORWARD_LOG_ENABLE", "0")
    return tmp_path


@contextmanager
def name_server(folder):
    with NameServer(port=0) as server:
        (folder / "yarp.conf").write_text(f"127.0.0.1 {server.port_number} yarp\n")
        yield NameClient.find()


@pytest.fixture
def names(folder):
    with name_server(folder) as names:
        yield names


def yarp(*arguments, text=None):
    done = subprocess.run(["yarp", *arguments], input=text, capture_output=True, text=True, timeout=PATIENCE)
    return done.stdout + done.stderr


class Tool:
    """A `yarp read` or `yarp write` in the background; it does not end by itself, nor when asked."""

    def __init__(self, *arguments):
        self.process = subprocess.Popen(
            ["yarp", *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            env={**os.environ, "YARP_QUIET": "1"},
        )

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.communicate()

    def line_with(self, text):
        for line in self.process.stdout:
            if text in line:
                return line
        raise AssertionError(f"{text!r} was not printed")


@contextmanager
def repeated(action):
    """Do something again and again meanwhile."""
    ended = threading.Event()

    def run():
        while not ended.wait(0.05):
            action()

    thread = threading.Thread(target=run)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


def in_own_network(action):
    """Run on a thread whose network, and that of all that it starts, is a loopback with multicast."""

    def run():
        enter_own_namespaces()
        subprocess.run(
            ["ip", "route", "add", "224.0.0.0/4", "dev", "lo", "src", "127.0.0.1"],
            check=True,
            timeout=PATIENCE,
        )
        action()

    if sys.platform != "linux" or os.geteuid() != 0 or not shutil.which("ip"):
        pytest.skip("a network of its own needs Linux, root and `ip`")
    with ThreadPoolExecutor(1) as pool:
        pool.submit(run).result()


def test_list_ping_and_rpc(names):
    with RpcServer("/ours/rpc", lambda request: Bottle([Vocab("ok"), *request.bottle()]), names):
        assert "/ours/rpc ip 127.0.0.1" in yarp("name", "list")
        assert 'This is "/ours/rpc"' in yarp("ping", "/ours/rpc")
        assert "Response: [ok] 1 2.5 (x y)" in yarp("rpc", "/ours/rpc", text="1 2.5 (x y)\n")


@pytest.mark.parametrize("carrier", ["tcp", "fast_tcp", "udp", "mjpeg", "unix_stream"])
def test_yarp_read_gets_our_images(names, carrier):
    with OutputPort("/ours", names) as output, Tool("read", "/theirs", "envelope") as reader:
        until(lambda: listens(names, "/theirs"))
        yarp("connect", "/ours", "/theirs", carrier)
        until(lambda: output.connections)
        for number in range(3):
            stamp = Stamp(number + 5, 1234.5).encode()
            output.write(*image.encode(np.full((4, 6, 3), 100, np.uint8), "rgb"), stamp)
            assert output.wait_sent(5)
        assert b"[rgb]" in reader.line_with(b"1234.5")


@pytest.mark.parametrize("carrier", ["tcp", "fast_tcp", "udp", "unix_stream", "text", "text_ack"])
def test_yarp_write_reaches_us(names, carrier):
    with InputPort("/ours", names) as port, Tool("write", "/theirs") as writer:
        until(lambda: listens(names, "/theirs"))
        port.connect("/theirs", carrier)
        until(lambda: port.sources == ["/theirs"])
        writer.process.stdin.write(b'1 2.5 "two words"\n')
        writer.process.stdin.flush()
        assert Bottle.decode(port.read(10)[0]) == [1, 2.5, "two words"]
        yarp("disconnect", "/theirs", "/ours")
        until(lambda: not port.sources)


def test_multicast_to_and_from_yarp(folder):
    """One stream for `yarp read` and a port of ours, then one of `yarp write` for two ports of ours."""

    def send_and_receive():
        with name_server(folder) as names:
            with (
                OutputPort("/ours", names) as output,
                InputPort("/also/ours", names) as port,
                Tool("read", "/theirs", "envelope") as reader,
            ):
                until(lambda: listens(names, "/theirs"))
                for name in ("/theirs", "/also/ours"):
                    assert "Added connection" in yarp("connect", "/ours", name, "mcast")
                assert "(connectionless 1)" in yarp("admin", "rpc", "/ours", text="list out /theirs\n")
                until(lambda: port.sources == ["/ours"])
                with repeated(lambda: output.write_bottle(Bottle(["hello"]), "1 1234.5")):
                    # The reader does not reply, so nobody knows when it listens.
                    assert b"hello" in reader.line_with(b"1234.5")
                assert port.read(PATIENCE)[1] == "1 1234.5"
                assert "Removed connection" in yarp("disconnect", "/ours", "/theirs")
            assert names.list("/tmp") == []

            with (
                InputPort("/a", names) as first,
                InputPort("/b", names) as second,
                Tool("write", "/theirs") as writer,
            ):
                until(lambda: listens(names, "/theirs"))
                for port in (first, second):
                    port.connect("/theirs", "mcast")
                until(lambda: first.sources and second.sources)
                writer.process.stdin.write(b'1 2.5 "two words"\n')
                writer.process.stdin.flush()
                for port in (first, second):
                    assert Bottle.decode(port.read(PATIENCE)[0]) == [1, 2.5, "two words"]
                yarp("disconnect", "/theirs", "/a")
                until(lambda: not first.sources)

    in_own_network(send_and_receive)


def test_yarps_bayer_converts_our_mono_images(names):
    with OutputPort("/ours", names) as output, Tool("read", "/theirs", "envelope") as reader:
        until(lambda: listens(names, "/theirs"))
        assert "Added" in yarp("connect", "/ours", "/theirs", "fast_tcp+recv.bayer+order.bggr")
        until(lambda: output.connections)
        output.write(*image.encode(np.full((4, 8), 100, np.uint8), "mono"), Stamp(5, 1234.5).encode())
        assert b"[mat] [rgb]" in reader.line_with(b"1234.5")


def test_yarps_mono_images_reach_us_as_a_bayer_pattern(names):
    samples = " ".join(str(number) for number in range(32))
    with InputPort("/ours", names) as port, Tool("write", "/theirs") as writer:
        until(lambda: listens(names, "/theirs"))
        assert "Added" in yarp("connect", "/theirs", "/ours", "tcp+recv.bayer+order.gbrg")
        until(lambda: port.sources == ["/theirs"])
        writer.process.stdin.write(f"[mat] [mono] (1 32 8 8 4) {{{samples}}}\n".encode())
        writer.process.stdin.flush()
        header, pixels = image.decode(port.read(PATIENCE)[0])
        assert header.code == "gbrg" and pixels.ravel().tolist() == list(range(32))


def test_a_plug_in_of_ours_that_is_missing_is_answered_as_by_yarp(names):
    """Both answer that the connection was added, and both list the carrier with its modifiers."""
    carrier = "tcp+send.portmonitor+type.dll+file.depthimage_to_mono"
    with OutputPort("/ours", names), InputPort("/in", names), Tool("write", "/theirs"):
        until(lambda: listens(names, "/theirs"))
        answers = [yarp("connect", name, "/in", carrier) for name in ("/ours", "/theirs")]
        assert "Added connection from /ours" in answers[0]
        assert answers[0].replace("/ours", "/theirs") == answers[1]
        listed = [yarp("admin", "rpc", name, text="list out /in\n") for name in ("/ours", "/theirs")]
        assert carrier in listed[0] and listed[0].replace("/ours", "/theirs") == listed[1]
        assert "Cannot connect" in yarp("connect", "/theirs", "/in", "tcp+recv.portmonitor+type.dll")

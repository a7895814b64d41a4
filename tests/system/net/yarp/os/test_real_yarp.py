"""Our ports and name server under the hands of YARP's own tools, any version, where they are on the PATH."""

import os
import shutil
import subprocess

import numpy as np
import pytest

from grabbergui.core.errors import GrabberError
from grabbergui.net.yarp import image
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.link import administer
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.name_server import NameServer
from grabbergui.net.yarp.os.ports import InputPort, OutputPort, RpcServer
from grabbergui.net.yarp.os.stamp import Stamp
from grabbergui.net.yarp.os.values import Vocab
from patience import PATIENCE, until

pytestmark = [
    pytest.mark.yarp,
    pytest.mark.skipif(not shutil.which("yarp"), reason="needs YARP's `yarp` on the PATH"),
]


@pytest.fixture
def names(tmp_path, monkeypatch):
    with NameServer(port=0) as server:
        (tmp_path / "yarp.conf").write_text(f"127.0.0.1 {server.port_number} yarp\n")
        monkeypatch.setenv("YARP_CONFIG_HOME", str(tmp_path))
        monkeypatch.setenv("YARP_FORWARD_LOG_ENABLE", "0")
        yield NameClient.find()


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


def listens(names, name):
    """A YARP port is registered before it listens; only an answer shows that it does."""
    try:
        return bool(administer(names.query(name).address, Bottle([Vocab("ver")])))
    except GrabberError:
        return False


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

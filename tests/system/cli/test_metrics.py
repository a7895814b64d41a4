"""Counters over HTTP, and logs as JSON."""

import re
import socket
import urllib.error
import urllib.request
from contextlib import ExitStack

import pytest

from grabbergui import sources
from grabbergui.cli.metrics import MOST_REQUESTS, MetricsServer, read_token
from grabbergui.config.allowed_addresses import AllowedAddresses
from grabbergui.core.errors import TransportError
from patience import PATIENCE


@pytest.fixture
def camera():
    camera = sources.create("sim:?width=64&height=48&fps=100")
    camera.open()
    yield camera
    camera.close()


def fetch(url):
    with urllib.request.urlopen(url, timeout=PATIENCE) as answer:
        return answer.headers["Content-Type"], answer.read().decode()


def test_the_counters_of_a_stream(camera):
    queue = camera.open_queue(8)
    camera.start()
    with MetricsServer(camera, "0", {"yarp": lambda: 7}) as server:
        for _ in range(5):
            queue.get(PATIENCE)
        kind, page = fetch(server.url)
        with pytest.raises(urllib.error.HTTPError, match="404") as refused:
            fetch(server.url.replace("/metrics", "/"))
        refused.value.close()

    assert kind.startswith("text/plain; version=0.0.4")
    assert int(re.search(r"^grabbergui_frames_total\{.*\} (\d+)$", page, re.M)[1]) >= 5
    assert "# TYPE grabbergui_frames_total counter" in page
    assert re.search(r'^grabbergui_published_total\{source="sim:.*",network="yarp"\} 7$', page, re.M)
    assert re.search(r"^grabbergui_streaming\{.*\} 1$", page, re.M)


def test_a_caller_that_says_nothing_holds_nobody_up(camera):
    with MetricsServer(camera, "127.0.0.1:0", {}) as server:
        port = int(server.url.split(":")[2].split("/")[0])
        with socket.create_connection(("127.0.0.1", port)) as silent:
            assert "grabbergui_streaming" in fetch(server.url)[1]
            with pytest.raises(TransportError, match="in use"):
                MetricsServer(camera, str(port), {})
            silent.sendall(b"nonsense\r\n\r\n")
            assert silent.recv(100)


def test_whoever_lacks_the_token_learns_nothing(camera, tmp_path):
    (tmp_path / "token").write_text("s3cret\n")
    with MetricsServer(camera, "0", {}, token=read_token(str(tmp_path / "token"))) as server:
        for header in ({}, {"Authorization": "Bearer wrong"}, {"Authorization": "Basic s3cret"}):
            with pytest.raises(urllib.error.HTTPError, match="401") as refused:
                fetch(urllib.request.Request(server.url, headers=header))
            assert not refused.value.read()
            refused.value.close()
        request = urllib.request.Request(server.url, headers={"Authorization": "Bearer s3cret"})
        assert "grabbergui_streaming" in fetch(request)[1]


def test_only_allowed_addresses_read_the_counters(camera, monkeypatch):
    monkeypatch.setattr(AllowedAddresses, "allows", lambda self, address, own="": address != "127.15.0.66")
    with MetricsServer(camera, "127.0.0.1:0", {}) as server:
        port = int(server.url.split(":")[2].split("/")[0])
        with socket.create_connection(("127.0.0.1", port), source_address=("127.15.0.66", 0)) as stranger:
            stranger.settimeout(PATIENCE)
            assert stranger.recv(100) == b""
        assert "grabbergui_streaming" in fetch(server.url)[1]


def test_many_callers_are_connected_before_the_first_is_accepted(camera):
    """A connection that finds no place is tried again a second later, and again after that."""
    server = MetricsServer(camera, "127.0.0.1:0", {})
    port = int(server.url.split(":")[2].split("/")[0])
    with ExitStack() as stack:
        stack.callback(server._server.server_close)
        callers = [
            stack.enter_context(socket.create_connection(("127.0.0.1", port), timeout=10)) for _ in range(40)
        ]
        assert all(caller.getpeername() == ("127.0.0.1", port) for caller in callers)


def test_callers_that_say_nothing_do_not_become_many(camera):
    with MetricsServer(camera, "127.0.0.1:0", {}) as server, ExitStack() as stack:
        port = int(server.url.split(":")[2].split("/")[0])
        silent = [stack.enter_context(socket.create_connection(("127.0.0.1", port))) for _ in range(40)]
        assert "grabbergui_streaming" in fetch(server.url)[1]
        for sock in silent[: 40 - MOST_REQUESTS]:
            sock.settimeout(PATIENCE)
            assert sock.recv(100) == b"", "the oldest gave way"


def test_counters_at_an_ipv6_address(camera):
    with MetricsServer(camera, "[::1]:0", {}) as server:
        assert server.url.startswith("http://[::1]:")
        assert "grabbergui_streaming" in fetch(server.url)[1]


@pytest.mark.parametrize(
    ("host", "reason"), [("a..b", "'a..b' is not a host name"), ("192.0.2.1", "Cannot assign")]
)
def test_an_address_that_cannot_be_had_is_named(camera, host, reason):
    with pytest.raises(TransportError, match=rf"--metrics {host}:0: {reason}"):
        MetricsServer(camera, f"{host}:0", {})


def test_the_names_of_this_machine_are_not_asked_for(camera, monkeypatch):
    """The server waits for no DNS, which may be far or broken."""
    monkeypatch.setattr(socket, "getfqdn", lambda *_: pytest.fail("asked DNS"))
    with MetricsServer(camera, "127.0.0.1:0", {}) as server:
        assert "grabbergui_streaming" in fetch(server.url)[1]

"""`serve --metrics`: the stream's counters for Prometheus, over HTTP, as its text format 0.0.4 has them."""

from __future__ import annotations

import hmac
import logging
import socket
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from socketserver import TCPServer
from typing import Any

from grabbergui.config.allowed_addresses import EVERYBODY, AllowedAddresses
from grabbergui.core.errors import ResourceExhaustedError, TransportError, UsageError
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.regular_files import read_bounded

log = logging.getLogger(__name__)

CONTENT_TYPE = "text/plain; version=0.0.4; charset=utf-8"
DEFAULT_HOST = "127.0.0.1"
REQUEST_TIMEOUT = 5.0
"""Seconds that a client may pause within its request."""

PAUSE = 1.0
"""Seconds before the next connection is accepted after file descriptors ran out."""

MOST_REQUESTS = 8
"""Most requests at a time, each on a thread of its own; the oldest is closed for a new one."""

_GAUGES = {
    "frame_rate": ("frame_rate_hertz", "Frames per second."),
    "bandwidth": ("bandwidth_bytes_per_second", "Payload bytes per second."),
}
_COUNTERS = {
    "frames": ("frames_total", "Complete frames since the stream was started."),
    "incomplete": ("frames_incomplete_total", "Frames with packets missing."),
    "lost": ("frames_lost_total", "Frames of which nothing arrived."),
    "underruns": ("frames_underrun_total", "Frames dropped because consumers held every buffer."),
    "bytes": ("payload_bytes_total", "Payload bytes of complete frames."),
    "packets": ("packets_total", "Packets received."),
    "packets_missing": ("packets_missing_total", "Packets that never arrived."),
    "packets_resent": ("packets_resent_total", "Packets that arrived after a resend request."),
    "packets_duplicate": ("packets_duplicate_total", "Packets that arrived twice."),
    "packets_ignored": ("packets_ignored_total", "Foreign, malformed or stale datagrams."),
    "packets_foreign": (
        "packets_foreign_total",
        "Datagrams that were not from the camera's stream port.",
    ),
    "packets_clipped": ("packets_clipped_total", "Last packets with padding beyond the payload's end."),
    "overruns": ("overruns_total", "Times that all queued packets were discarded to catch up."),
}

Published = Mapping[str, Callable[[], int]]
"""The number of images sent, by network."""
_MAX_TOKEN_BYTES = 1 << 16


def exposition(grabber: FrameGrabber, published: Published) -> str:
    """Return the page: each metric with help, type and value, labelled with the source's URI."""
    label = f'source="{_escaped(grabber.info.uri)}"'
    lines = _metric("streaming", "gauge", "Whether the stream is on.", {label: int(grabber.streaming)})
    lines += _metric(
        "camera_lost",
        "gauge",
        "Whether the camera is lost and searched for.",
        {label: int(bool(grabber.lost))},
    )
    values = grabber.statistics().as_dict()
    for kind, table in (("gauge", _GAUGES), ("counter", _COUNTERS)):
        for field, (name, meaning) in table.items():
            lines += _metric(name, kind, meaning, {label: values[field]})
    if published:
        sent = {f'{label},network="{network}"': count() for network, count in published.items()}
        lines += _metric("published_total", "counter", "Images sent on a network.", sent)
    return "\n".join(lines) + "\n"


def _metric(name: str, kind: str, meaning: str, values: Mapping[str, float]) -> list[str]:
    name = f"grabbergui_{name}"
    samples = [f"{name}{{{labels}}} {value:.15g}" for labels, value in values.items()]
    return [f"# HELP {name} {meaning}", f"# TYPE {name} {kind}", *samples]


def _escaped(text: str) -> str:
    return text.replace("\\", r"\\").replace('"', r"\"").replace("\n", r"\n")


def parse_address(text: str) -> tuple[str, int]:
    """Parse `HOST:PORT`, or `PORT` on this machine only. Raises UsageError."""
    host, _, port = text.rpartition(":")
    if not port.isascii() or not port.isdigit() or int(port) > 65535:
        raise UsageError(f"--metrics {text}: write HOST:PORT, or PORT for this machine only")
    return host.strip("[]") or DEFAULT_HOST, int(port)


def read_token(path: str) -> str:
    """Return the token in a file, which only its owner should be able to read. Raises UsageError."""
    try:
        token = read_bounded(Path(path), _MAX_TOKEN_BYTES, "token").decode("ascii").strip()
    except (OSError, UnicodeError, UsageError) as error:
        raise UsageError(f"--metrics-token {path}: {error}") from error
    if not token:
        raise UsageError(f"--metrics-token {path}: the file is empty; write a token into it")
    return token


class MetricsServer:
    """Answers GET /metrics. One thread, and one for each request; reads no feature of the camera."""

    def __init__(
        self,
        grabber: FrameGrabber,
        address: str,
        published: Published,
        *,
        token: str = "",
        allowed: AllowedAddresses = EVERYBODY,
    ) -> None:
        """Bind. With a `token` requests need the header `Authorization: Bearer TOKEN`.

        Raises UsageError for a malformed address, TransportError if it cannot be bound.
        """
        host, port = parse_address(address)
        expected = f"Bearer {token}".encode() if token else b""

        class Handler(BaseHTTPRequestHandler):
            timeout = REQUEST_TIMEOUT

            def do_GET(self) -> None:
                given = self.headers.get("Authorization", "").encode("latin-1", "replace")
                if expected and not hmac.compare_digest(given, expected):
                    self.send_response(401)
                    self.send_header("WWW-Authenticate", "Bearer")
                    self.send_header("Content-Length", "0")
                    self.end_headers()
                    return
                if self.path.partition("?")[0] != "/metrics":
                    self.send_error(404, "the figures are at /metrics")
                    return
                body = exposition(grabber, published).encode()
                self.send_response(200)
                self.send_header("Content-Type", CONTENT_TYPE)
                self.send_header("Content-Length", str(len(body)))
                self.end_headers()
                self.wfile.write(body)

            def log_message(self, format: str, *args: object) -> None:  # noqa: A002 (its name there)
                log.debug("metrics for %s: %s", self.address_string(), format % args)

        try:
            self._server = _Server((host, port), Handler, allowed)
        except OSError as error:
            raise TransportError(f"--metrics {address}: {error.strerror or error}") from error
        except UnicodeError as error:  # a..b, or a part of more than 63 letters
            raise TransportError(f"--metrics {address}: '{host}' is not a host name") from error
        self._thread = threading.Thread(target=self._server.serve_forever, name="metrics", daemon=True)

    @property
    def url(self) -> str:
        """The URL of the page."""
        host, port = self._server.server_address[:2]
        return f"http://[{host!s}]:{port}/metrics" if ":" in str(host) else f"http://{host!s}:{port}/metrics"

    def __enter__(self) -> MetricsServer:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    # A silent client must not delay the end.
    block_on_close = False
    # Python's 5 are too few for callers that come at once: the others' connections take a second and more.
    request_queue_size = 128

    def __init__(
        self, address: tuple[str, int], handler: type[BaseHTTPRequestHandler], allowed: AllowedAddresses
    ) -> None:
        self._allowed = allowed
        self._requests: dict[socket.socket, None] = {}
        "The requests in progress, oldest first."
        self._lock = threading.Lock()
        self.address_family = socket.getaddrinfo(*address, type=socket.SOCK_STREAM)[0][0]
        super().__init__(address, handler)

    def server_bind(self) -> None:
        TCPServer.server_bind(self)  # HTTP's own asks DNS for this machine's name, which may take long

    def verify_request(self, request: Any, client_address: Any) -> bool:
        return self._allowed.allows(client_address[0], request.getsockname()[0])

    def get_request(self) -> tuple[socket.socket, Any]:
        try:
            return super().get_request()
        except OSError as error:
            if failure := ResourceExhaustedError.of(error):
                log.warning("metrics: nobody can connect: %s", failure)
                time.sleep(PAUSE)  # the connection stays pending, so that no pause means a busy loop
            raise

    def process_request(self, request: Any, client_address: Any) -> None:
        with self._lock:
            if len(self._requests) >= MOST_REQUESTS:
                oldest = next(iter(self._requests))
                del self._requests[oldest]
                with suppress(OSError):
                    oldest.shutdown(socket.SHUT_RDWR)
            self._requests[request] = None
        super().process_request(request, client_address)

    def shutdown_request(self, request: Any) -> None:
        with self._lock:
            self._requests.pop(request, None)
        super().shutdown_request(request)

    def handle_error(self, request: object, client_address: object) -> None:
        log.debug("metrics for %s: broken off", client_address, exc_info=True)

"""HTTP/1.0 of a port: its web page, to which `yarp detect` links, and the head of an mjpeg stream. No I/O."""

from __future__ import annotations

import re
from collections.abc import Iterable
from html import escape
from typing import Final

REQUEST_LINES: Final = 100
LINE_LIMIT: Final = 8192
"""Of a browser's request."""

NOT_FOUND: Final = b"HTTP/1.0 404 Not Found\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"

BOUNDARY: Final = b"--boundarydonotcross\r\n"
"""Between two JPEG images over mjpeg."""

STREAM_REQUEST: Final = b"GET /?action=stream\n\n HTTP/1.1\nHost: %s\r\n\n"
"""As YARP's readers of mjpeg send it, odd line ends included; `%s` is the source's address."""

STREAM_RESPONSE: Final = (
    b"HTTP/1.0 200 OK\r\nConnection: close\r\nServer: yarp/mjpeg_carrier/0.1\r\n"
    b"Cache-Control: no-store, no-cache, must-revalidate, pre-check=0, post-check=0, max-age=0\r\n"
    b"Pragma: no-cache\r\nExpires: Mon, 3 Jan 2000 12:34:56 GMT\r\n"
    b"Content-Type: multipart/x-mixed-replace;boundary=boundarydonotcross\r\n\r\n" + BOUNDARY
)
"""As YARP's sources of mjpeg answer."""

PICTURES: Final = "/?action=stream"
"""Path of a port's mjpeg stream."""

_PLACE: Final = re.compile(r"tcp://([\w.\-\[\]:]+:\d+)/", re.ASCII)
_STYLE: Final = "body{font:1em sans-serif;margin:2em}img{max-width:100%}"


def wanted(request_line: str) -> bool:
    """Return whether the browser requests the page rather than an icon."""
    return request_line.split(" ")[1:2] == ["/"]


def encode_page(title: str, lines: Iterable[str], *, pictures: bool = False) -> bytes:
    """Return an HTML answer with lines of text; ports' addresses become links, `pictures` are live images."""
    shown = "".join(f"<li>{_linked(escape(line))}</li>" for line in lines)
    picture = f'<img src="{PICTURES}" alt="{escape(title)}">' if pictures else ""
    body = (
        f'<!DOCTYPE html><html><head><meta charset="utf-8"><title>{escape(title)}</title>'
        f"<style>{_STYLE}</style></head>"
        f"<body><h1>{escape(title)}</h1>{picture}<ul>{shown}</ul></body></html>"
    ).encode("utf-8", "replace")
    head = (
        "HTTP/1.0 200 OK\r\nContent-Type: text/html; charset=utf-8\r\n"
        f"Content-Length: {len(body)}\r\nCache-Control: no-store\r\nConnection: close\r\n\r\n"
    )
    return head.encode() + body


def _linked(text: str) -> str:
    return _PLACE.sub(r'<a href="http://\1/">\g<0></a>', text)

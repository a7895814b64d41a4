"""The page that a port shows to a browser, to which `yarp detect` links."""

from __future__ import annotations

import re
from collections.abc import Iterable
from html import escape
from typing import Final

from grabbergui.net.yarp.os.carrier import STREAM_PATH

PAGE_NOT_FOUND: Final = b"HTTP/1.0 404 Not Found\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"

_PLACE: Final = re.compile(r"tcp://([\w.\-\[\]:]+:\d+)/", re.ASCII)
_STYLE: Final = "body{font:1em sans-serif;margin:2em}img{max-width:100%}"


def page_wanted(request_line: str) -> bool:
    """Return whether the browser requests the page rather than an icon."""
    return request_line.split(" ")[1:2] == ["/"]


def encode_page(title: str, lines: Iterable[str], *, images: bool = False) -> bytes:
    """Return an HTML answer with lines of text; ports' addresses become links, `images` are live images."""
    shown = "".join(f"<li>{_linked(escape(line))}</li>" for line in lines)
    image = f'<img src="{STREAM_PATH}" alt="{escape(title)}">' if images else ""
    body = (
        f'<!DOCTYPE html><html><head><meta charset="utf-8"><title>{escape(title)}</title>'
        f"<style>{_STYLE}</style></head>"
        f"<body><h1>{escape(title)}</h1>{image}<ul>{shown}</ul></body></html>"
    ).encode("utf-8", "replace")
    head = (
        "HTTP/1.0 200 OK\r\nContent-Type: text/html; charset=utf-8\r\n"
        f"Content-Length: {len(body)}\r\nCache-Control: no-store\r\nConnection: close\r\n\r\n"
    )
    return head.encode() + body


def _linked(text: str) -> str:
    return _PLACE.sub(r'<a href="http://\1/">\g<0></a>', text)

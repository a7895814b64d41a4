"""Carriers, targets, the events of a connection, and their binary form. No I/O.

A connection begins with a header, eight bytes that name its carrier and the sender's name, and the receiver's
header reply. Messages follow: an index of block lengths, a port command, the body. All integers are little
endian. `connection` defines which event may follow which.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from ipaddress import IPv4Address
from typing import Final

from grabbergui.core.errors import LocalProtocolError, RemoteProtocolError
from grabbergui.net.yarp.os.binary import (
    _I32,
    MAGIC_BASE,
    NAME_LIMIT,
    decode_number,
    encode_number,
)
from grabbergui.net.yarp.os.bottle import Buffer

STREAM_PATH: Final = "/?action=stream"
"""Path of a port's mjpeg stream."""
STREAM_REQUEST: Final = b"GET /?action=stream\n\n HTTP/1.1\nHost: %s\r\n\n"
"""As YARP's readers of mjpeg send it, odd line ends included; `%s` is the source's address."""
BOUNDARY: Final = b"--boundarydonotcross\r\n"
"""Between two JPEG images over mjpeg."""
STREAM_RESPONSE: Final = (
    b"HTTP/1.0 200 OK\r\nConnection: close\r\nServer: yarp/mjpeg_carrier/0.1\r\n"
    b"Cache-Control: no-store, no-cache, must-revalidate, pre-check=0, post-check=0, max-age=0\r\n"
    b"Pragma: no-cache\r\nExpires: Mon, 3 Jan 2000 12:34:56 GMT\r\n"
    b"Content-Type: multipart/x-mixed-replace;boundary=boundarydonotcross\r\n\r\n" + BOUNDARY
)
"""As YARP's sources of mjpeg answer."""
REQUEST_LINES: Final = 100
REQUEST_LINE_LIMIT: Final = 8192
"""Largest request of a browser: its lines, and the bytes of each."""
_UNIX: Final = b"UNIX_STR"
_FOREIGN: Final = {14: "shmem"}
_GROUP: Final = struct.Struct(">4sH")
"""A multicast group's address and port, both big-endian, behind the header of mcast."""
GROUP_BYTES: Final = _GROUP.size


@dataclass(frozen=True)
class Carrier:
    """One way to move messages."""

    name: str
    code: int | None = None
    "Added to 7777 in the header; None for carriers whose header is text."
    acknowledged: bool = False
    datagrams: bool = False
    text: bool = False
    pull: bool = False
    "The reader connects to the source."
    local: bool = False
    "A socket of this computer takes the place of the connection, after a header without a reply."
    multicast: bool = False
    "A group, which the header names, takes the place of the connection; the header has no reply."

    @property
    def replies(self) -> bool:
        """Whether the receiver replies to the header."""
        return not (self.local or self.multicast)

    @property
    def switches(self) -> bool:
        """Whether another protocol follows the header reply: datagrams, HTTP."""
        return self.datagrams or self.pull


TCP = Carrier("tcp", 3 + 128, acknowledged=True)
FAST_TCP = Carrier("fast_tcp", 3)
UDP = Carrier("udp", 0, datagrams=True)
MCAST = Carrier("mcast", 1, datagrams=True, multicast=True)
TEXT = Carrier("text", text=True)
TEXT_ACK = Carrier("text_ack", text=True, acknowledged=True)
MJPEG = Carrier("mjpeg", pull=True)
UNIX_STREAM = Carrier("unix_stream", local=True)

CARRIERS: Final = {
    carrier.name: carrier for carrier in (TCP, FAST_TCP, UDP, MCAST, TEXT, TEXT_ACK, MJPEG, UNIX_STREAM)
}
"""Those that we offer, by name."""

HTTP = Carrier("http", pull=True)
"""A browser's request for the port's page. It carries no messages, so it is not offered."""


NAME_SER = Carrier("name_ser", text=True)
"""A name server's line protocol: neither header nor header reply, one line a request."""


def by_name(name: str) -> Carrier:
    """Return the carrier of ``fast_tcp`` or ``udp+recv.bayer``. Raises LocalProtocolError if we lack it."""
    base = name.partition("+")[0]
    if base not in CARRIERS:
        raise LocalProtocolError(f"carrier {base} is not supported, use one of {', '.join(CARRIERS)}")
    return CARRIERS[base]


def identify(header: Buffer) -> Carrier:
    """Return the carrier that the first eight bytes of a connection name. Raises RemoteProtocolError."""
    first = bytes(header[:8])
    texts = {
        b"CONNECT ": TEXT,
        b"CONNACK ": TEXT_ACK,
        b"GET /?ac": MJPEG,
        b"NAME_SER": NAME_SER,
        _UNIX: UNIX_STREAM,
    }
    if first in texts:
        return texts[first]
    if first.startswith(b"GET /"):
        return HTTP
    number = decode_number(first)
    code = number - MAGIC_BASE
    for carrier in CARRIERS.values():
        if carrier.code == code:
            return carrier
    name = _FOREIGN.get(code & 15, f"with code {code}")
    raise RemoteProtocolError(f"carrier {name} is not supported, use one of {', '.join(CARRIERS)}")


def modifiers_of(carrier: str) -> dict[str, str]:
    """Return the modifiers of a carrier: {"recv": "bayer"} of `tcp+recv.bayer`."""
    return {key: value for key, _, value in (part.partition(".") for part in carrier.split("+")[1:])}


def encode_header(carrier: Carrier, sender: str, group: tuple[str, int] | None = None) -> bytes:
    """Return the first bytes from the side that opens a connection; mcast names its `group`.

    Raises LocalProtocolError.
    """
    if carrier.code is None and not carrier.local:
        word = "CONNACK" if carrier.acknowledged else "CONNECT"
        return f"{word} {sender}\r\n".encode("utf-8", "surrogateescape")
    name = sender.encode("utf-8", "surrogateescape") + b"\0"
    if len(name) > NAME_LIMIT:
        raise LocalProtocolError(f"port name of {len(name)} bytes, at most {NAME_LIMIT}")
    start = _UNIX if carrier.code is None else encode_number(MAGIC_BASE + carrier.code)
    return start + _I32.pack(len(name)) + name + (encode_group(group) if group else b"")


def encode_group(group: tuple[str, int]) -> bytes:
    """Encode a multicast group's address and port. Raises LocalProtocolError."""
    host, port = group
    try:
        address = IPv4Address(host)
    except ValueError:
        address = IPv4Address(0)
    if not address.is_multicast or not 0 < port < 65536:
        raise LocalProtocolError(f"{host}:{port} is no multicast group: 224.0.0.0 to 239.255.255.255")
    return _GROUP.pack(address.packed, port)


def decode_group(data: Buffer) -> tuple[str, int]:
    """Return the address and port of a multicast group. Raises RemoteProtocolError."""
    packed, port = _GROUP.unpack(data)
    address = IPv4Address(packed)
    if not address.is_multicast or not port:
        raise RemoteProtocolError(f"{address}:{port} is no multicast group: 224.0.0.0 to 239.255.255.255")
    return str(address), port

"""Requests to a YARP port without our client, for replies whose bytes matter or are not a Bottle."""

from __future__ import annotations

import socket

from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os.binary import ACK, encode_message
from grabbergui.net.yarp.os.carrier import encode_header
from patience import PATIENCE


def reply_to(address: tuple[str, int], request: bytes) -> bytes:
    """Send a request over tcp, and return all bytes before its acknowledgement."""
    with socket.create_connection(address, PATIENCE) as sock:
        sock.sendall(encode_header(wire.TCP, "/tests"))
        sock.recv(8, socket.MSG_WAITALL)  # the reply to the header
        sock.sendall(b"".join(bytes(piece) for piece in encode_message("d", [request])))
        reply = b""
        while not reply.endswith(ACK):
            received = sock.recv(4096)
            assert received, f"the port hung up after {reply!r}"
            reply += received
        return reply.removesuffix(ACK)

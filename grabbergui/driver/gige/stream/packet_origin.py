"""Which datagrams belong to a stream: those that come from the camera's address and stream port.

Anybody on the network can send datagrams with the camera's address; only those from the UDP port that it
sends this stream from are taken. The camera names the port in SCSP (GigE Vision 2.2, "Stream Channel Source
Port"), and a test packet shows it. Where neither does, the first packet from the camera's address decides.
Some cameras name another port than they send from. So if nothing ever came from the named port, another one
counts after a second, until a packet from the named one arrives after all.
"""

from __future__ import annotations

import logging
import socket
import struct
from collections.abc import Iterable

log = logging.getLogger(__name__)

PATIENCE = 1.0
"Seconds for which packets from another port are refused, though none came from the named one."

_ADDRESS = struct.Struct("=HH4s")
"Family, port in network order, address: the beginning of Linux's `struct sockaddr_in`."
_KEY = struct.Struct("=Q")


class PacketOrigin:
    """The sender of one stream. No I/O; one thread at a time."""

    def __init__(self, ip: str, named: int = 0, tested: int = 0) -> None:
        """`named` is the port in SCSP, `tested` the one that a test packet came from; 0: unknown."""
        self.ip = ip
        self.key = 0
        "The first 8 bytes of the sender's `sockaddr_in`, as a number of this machine's byte order."
        self._named = named
        self._port = 0
        self.heard = bool(tested)
        "Whether a packet from the known port has arrived, so that no other may follow. Set by sources, too."
        self._others_since: float | None = None
        self._reported = False
        self._use(tested or named)
        if named and tested and named != tested:
            log.info("%s names stream port %d in SCSP, and sends from %d", ip, named, tested)

    def _use(self, port: int) -> None:
        self._port = port
        self.key = key_of(self.ip, port)

    def admits(self, ip: str, port: int, now: float) -> bool:
        """Return whether a datagram from there belongs to the stream. `now` in seconds of any clock."""
        if (ip, port) == (self.ip, self._port) or (ip == self.ip and self._learn([port], now)):
            self.heard = True
            return True
        self._report(ip, port)
        return False

    def learn(self, keys: Iterable[int], now: float) -> bool:
        """Take the keys of datagrams from other senders; return whether one of them is the camera, by now."""
        strangers = [_ADDRESS.unpack(_KEY.pack(int(key))) for key in keys]
        family, own = socket.AF_INET, socket.inet_aton(self.ip)
        ports = [socket.ntohs(port) for kind, port, address in strangers if kind == family and address == own]
        if ports and self._learn(ports, now):
            return True
        _, port, address = strangers[0]
        self._report(socket.inet_ntoa(address), socket.ntohs(port))
        return False

    def _learn(self, ports: list[int], now: float) -> bool:
        """Decide whether one of other ports of the camera's address is that of the stream."""
        if self._named in ports and self._port != self._named:
            self._use(self._named)
            return True
        if self._port and self.heard:
            return False
        if self._port:
            if self._others_since is None:
                self._others_since = now
            if now - self._others_since < PATIENCE:
                return False
            log.warning("%s names stream port %d, but sends from %d", self.ip, self._port, ports[0])
        self._use(ports[0])
        return True

    def _report(self, ip: str, port: int) -> None:
        if not self._reported:
            self._reported = True
            log.warning(
                "packets from %s port %d are refused: the stream comes from %s port %d",
                *(ip, port, self.ip, self._port),
            )


def key_of(ip: str, port: int) -> int:
    """Return the first 8 bytes of a `sockaddr_in` as a number."""
    number: int = _KEY.unpack(_ADDRESS.pack(socket.AF_INET, socket.htons(port), socket.inet_aton(ip)))[0]
    return number

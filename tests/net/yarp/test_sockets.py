"""Sockets of ports: what a peer did is seen without waiting."""

from __future__ import annotations

import socket

from grabbergui.net.yarp.os import sockets


def test_a_peer_that_closed_is_noticed_and_one_that_waits_or_sends_is_not() -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        assert not sockets.closed_by_peer(ours)
        theirs.send(b"x")
        assert not sockets.closed_by_peer(ours)
        assert ours.recv(1) == b"x"  # looking has taken nothing
        theirs.close()
        assert sockets.closed_by_peer(ours)
    assert sockets.closed_by_peer(ours)

"""Whose packets a stream takes: those from the camera's address and stream port."""

from __future__ import annotations

import logging
import socket
import sys

import pytest

from grabbergui.driver.gige.stream.packet_origin import PacketOrigin, key_of

CAMERA, STRANGER = "127.0.0.7", "127.0.0.8"
NAMED, OTHER, THIRD = 4000, 5000, 6000


class Asked:
    """A rule that is asked packet by packet, as a plain socket does, or by batches of keys."""

    def __init__(self, origin: PacketOrigin, *, by_keys: bool) -> None:
        self.origin, self._by_keys = origin, by_keys

    def admits(self, ip: str, port: int, now: float = 0.0) -> bool:
        if not self._by_keys:
            return self.origin.admits(ip, port, now)
        key = key_of(ip, port)
        if key != self.origin.key and not (self.origin.learn([key], now) and key == self.origin.key):
            return False
        self.origin.heard = True
        return True


@pytest.fixture(params=[False, True], ids=["packets", "keys"])
def asked(request: pytest.FixtureRequest):  # type: ignore[no-untyped-def]
    return lambda *ports: Asked(PacketOrigin(CAMERA, *ports), by_keys=request.param)


def test_only_the_named_port_of_the_camera_is_taken(asked, caplog) -> None:  # type: ignore[no-untyped-def]
    rule = asked(NAMED)
    for now in range(3):
        assert not rule.admits(STRANGER, NAMED, now)
    assert not rule.admits(CAMERA, OTHER) and rule.admits(CAMERA, NAMED)
    for now in range(100):
        assert not rule.admits(CAMERA, OTHER, now), "also while the camera waits for a trigger"
    assert rule.admits(CAMERA, NAMED, 200)
    (message,) = caplog.messages
    assert f"packets from {STRANGER} port {NAMED} are refused" in message
    assert message.endswith(f"the stream comes from {CAMERA} port {NAMED}")


def test_the_first_packet_of_the_camera_decides_where_it_names_no_port(asked) -> None:  # type: ignore[no-untyped-def]
    rule = asked()
    assert not rule.admits(STRANGER, OTHER)
    assert rule.admits(CAMERA, OTHER)
    assert not rule.admits(CAMERA, THIRD, 100) and rule.admits(CAMERA, OTHER, 100)


def test_a_camera_that_sends_from_another_port_than_it_names_is_believed_after_a_second(  # type: ignore[no-untyped-def]
    asked, caplog
) -> None:
    rule = asked(NAMED)
    assert not rule.admits(CAMERA, OTHER, 10.0) and not rule.admits(CAMERA, OTHER, 10.9)
    assert rule.admits(CAMERA, OTHER, 11.0)
    assert any(f"names stream port {NAMED}, but sends from {OTHER}" in text for text in caplog.messages)
    assert not rule.admits(CAMERA, THIRD, 30.0)
    assert rule.admits(CAMERA, NAMED, 31.0), "it was a stranger after all"
    assert not rule.admits(CAMERA, OTHER, 40.0)


def test_a_test_packet_shows_the_port(asked, caplog) -> None:  # type: ignore[no-untyped-def]
    caplog.set_level(logging.INFO)
    rule = asked(NAMED, OTHER)
    assert rule.admits(CAMERA, OTHER) and "names stream port 4000 in SCSP, and sends from 5000" in caplog.text
    rule = asked(0, OTHER)
    assert rule.admits(CAMERA, OTHER) and not rule.admits(CAMERA, THIRD, 100)


def test_a_key_is_what_the_kernel_writes() -> None:
    written = PacketOrigin("1.2.3.4", 0x0506).key.to_bytes(8, sys.byteorder)
    assert written == socket.AF_INET.to_bytes(2, sys.byteorder) + bytes([5, 6, 1, 2, 3, 4])

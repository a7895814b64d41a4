"""A name server of our own and a shared simulated camera, for tests of both ends."""

from __future__ import annotations

import os
import random
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from grabbergui import sources
from grabbergui.core.errors import TransportError
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.uri import SourceUri
from grabbergui.net.yarp import client, grabber_service, grabber_values
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.name_server import NameServer
from grabbergui.net.yarp.os.values import Vocab
from grabbergui.net.yarp.server import YarpGrabberServer
from grabbergui.terminal import remote_terminal

HOST = "127.0.0.1"


class Stage:
    """The name server and the camera of a test."""

    def __init__(self, name_server: NameServer, grabber: FrameGrabber) -> None:
        self.name_server = name_server
        self.address = f"{HOST}:{name_server.port_number}"
        self.names = NameClient.find(self.address)
        self.grabber = grabber

    def share(self, name: str = "/grabber", **options: object) -> YarpGrabberServer:
        """A server for the camera, not yet started."""
        terminal = remote_terminal(self.grabber)
        return YarpGrabberServer(self.grabber, name, names=self.names, terminal=terminal, **options)  # type: ignore[arg-type]


def _name_server() -> NameServer:
    """Below the numbers that the system gives out itself: real YARP ports get those just above."""
    for port in random.Random(os.getpid()).sample(range(11_000, 32_000, 100), 20):
        name_server = NameServer(HOST, port)
        try:
            name_server.open()
        except TransportError:
            continue
        return name_server
    raise AssertionError("no free port for a name server")


@contextmanager
def stage() -> Iterator[Stage]:
    """Everything up, and down again."""
    name_server = _name_server()
    grabber = sources.create("sim:")
    try:
        grabber.open()
        grabber.write_feature("Width", 168)
        grabber.write_feature("Height", 100)
        yield Stage(name_server, grabber)
    finally:
        grabber.close()
        name_server.close()


def connect(scene: Stage, uri: str = "yarp:/grabber") -> FrameGrabber:
    """A remote camera at the scene's name server, not yet open."""
    parsed = SourceUri.parse(uri)
    return client.create(
        SourceUri(parsed.scheme, parsed.name, {**parsed.options, "nameserver": scene.address})
    )


def pretend_to_be_yarps_own(monkeypatch: pytest.MonkeyPatch, version: str) -> None:
    """Let our servers answer as YARP's own, of version 3.x or 4.0, which know nothing of our requests."""
    answer = grabber_service.GrabberService.answer
    foreign = Vocab("nak") if version == "3.x" else Vocab("fail")

    def pretend(self: grabber_service.GrabberService, message: Bottle) -> object:
        thrift = isinstance(message[0], str)
        if grabber_values.is_tree_request(message) or thrift == (version == "3.x"):
            return [Bottle([foreign]).encode()] if thrift else None
        return answer(self, message)

    monkeypatch.setattr(grabber_service.GrabberService, "answer", pretend)

"""The served camera that the tests of a module share; name servers, and the end of all threads."""

from __future__ import annotations

import os
import tempfile
import threading
import time
from collections.abc import Iterator

import pytest

from grabber_stage import Stage, stage
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.name_server import NameServer
from patience import PATIENCE


@pytest.fixture(autouse=True, scope="session")
def runtime_folder() -> Iterator[None]:
    """Keep the sockets of unix_stream, ours and a real YARP's, in a folder with a short name."""
    with tempfile.TemporaryDirectory() as folder:
        os.environ["YARP_RUNTIME_DIR"] = folder
        yield
        del os.environ["YARP_RUNTIME_DIR"]


@pytest.fixture(scope="module")
def scene() -> Iterator[Stage]:
    with stage() as scene:
        yield scene


@pytest.fixture
def coloured(scene: Stage) -> Iterator[Stage]:
    """The camera in a format with colours, so that it has balance ratios; as it was behind the test."""
    before = scene.grabber.feature("PixelFormat").value
    assert before is not None
    scene.grabber.write_feature("PixelFormat", "RGB8")
    yield scene
    scene.grabber.write_feature("PixelFormat", before)


@pytest.fixture
def names() -> Iterator[NameClient]:
    """Return the client of a name server of the test's own."""
    with NameServer(port=0) as server:
        yield NameClient(server.contact)


@pytest.fixture
def no_thread_is_left() -> Iterator[None]:
    """Wait after the test until every thread of its ports has ended, and name those that have not.

    A thread that was there before the test is another's, which has reported it.
    """
    before = set(threading.enumerate())
    yield
    begun = time.monotonic()
    started = [t for t in threading.enumerate() if t.name.startswith("yarp ") and t not in before]
    for thread in started:
        thread.join(max(0.0, begun + PATIENCE - time.monotonic()))
    left = [thread.name for thread in started if thread.is_alive()]
    assert not left, f"threads left behind: {left}"

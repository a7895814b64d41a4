"""A program with more than a thousand open files receives, searches and measures all the same."""

from __future__ import annotations

import os
import resource
import socket
from collections.abc import Iterator

import pytest

from grabbergui.driver.gige.stream.waits import readable

FIRST_BEYOND = 1024
"Descriptors from here on do not fit into the set of `select`."


@pytest.fixture
def receiver() -> Iterator[socket.socket]:
    """A socket whose descriptor is beyond what `select` takes."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if hard < FIRST_BEYOND + 100:
        pytest.skip(f"this system allows only {hard} open files")
    resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, FIRST_BEYOND + 100), hard))
    filled = [os.open(os.devnull, os.O_RDONLY)]
    while filled[-1] < FIRST_BEYOND:
        filled.append(os.dup(filled[0]))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as opened:
        assert opened.fileno() > FIRST_BEYOND
        opened.bind(("127.0.0.1", 0))
        yield opened
    for descriptor in filled:
        os.close(descriptor)
    resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def test_a_socket_beyond_the_thousandth_file_is_waited_for(receiver: socket.socket) -> None:
    assert readable([receiver], 0.0) == []
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.sendto(b"image", receiver.getsockname())
        assert readable([receiver], 5.0) == [receiver]

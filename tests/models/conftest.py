"""A connection whose sources are scripted."""

import threading

import pytest
from connection_bench import Bench

from patience import PATIENCE


@pytest.fixture
def bench():
    bench = Bench()
    yield bench
    bench.source.opening.set()
    bench.link.close_all()
    assert bench.link.wait_closed(PATIENCE)
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("features ")]

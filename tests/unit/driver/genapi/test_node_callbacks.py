"""Nodes report their changes, for days on end."""

import gc
import sys
from pathlib import Path

import pytest

from fakes import XmlDevice
from grabbergui.driver.genapi import node_callbacks
from grabbergui.driver.genapi.node_callbacks import binding_leaks
from grabbergui.driver.genapi.node_map import CameraNodeMap

XML = (Path(__file__).parents[3] / "data" / "genapi" / "test_camera.xml").read_bytes()


@pytest.fixture
def nodes():
    node_map = CameraNodeMap(XmlDevice(XML), XML, lambda names: None)
    yield node_map
    node_map.close()


def growth(nodes, times):
    """Blocks of memory more that Python holds after so many changes."""
    gc.collect()
    before = sys.getallocatedblocks()
    for _ in range(times):
        nodes.invalidate(frozenset({"Width"}))
    gc.collect()
    return sys.getallocatedblocks() - before


def test_changes_leave_nothing_behind(nodes):
    growth(nodes, 100)
    # One reference left at each would be 3 blocks.
    assert growth(nodes, 1500) < 1000


class Handed:
    """The node that a binding without the leak passes to a callback."""

    def __init__(self, node):
        self.node = node


def test_that_the_binding_leaks_is_found_out_and_not_assumed(monkeypatch):
    """If the binding releases nodes by itself, a second release would free what is in use."""
    kept, register = [], node_callbacks.register

    def mended(node, callback):
        return register(node, lambda value: callback(Handed(value.node)))

    def leaking(node, callback):
        def call(value):
            kept.append(value)
            callback(value)

        return register(node, call)

    monkeypatch.setattr(node_callbacks, "register", mended)
    assert binding_leaks.__wrapped__() is False
    monkeypatch.setattr(node_callbacks, "register", leaking)
    assert binding_leaks.__wrapped__() is True

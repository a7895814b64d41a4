"""Calls from other threads arrive on the GUI thread in order, and never once the bridge is closed."""

import threading

import pytest
from psygnal import Signal
from PyQt5 import sip
from PyQt5.QtCore import QObject

from grabbergui.ui.gui_thread import Bridge


class Model:
    changed = Signal(int)


@pytest.fixture
def owner(qapp):
    return QObject()


def test_signals_of_a_thread_arrive_here_in_order(owner, qtbot):
    model, got = Model(), []
    Bridge(owner).bind(model.changed, lambda number: got.append((number, threading.current_thread())))
    thread = threading.Thread(target=lambda: [model.changed.emit(number) for number in range(3)])
    thread.start()
    thread.join()
    assert got == []
    qtbot.waitUntil(lambda: len(got) == 3)
    assert got == [(number, threading.main_thread()) for number in range(3)]


def test_a_closed_bridge_drops_what_waits_and_leaves_nothing_behind(owner, qapp, qtbot):
    model, got = Model(), []
    bridge = Bridge(owner)
    bridge.bind(model.changed, got.append)
    model.changed.emit(1)
    bridge.close()
    model.changed.emit(2)
    bridge.call(lambda: got.append(3))
    qtbot.waitUntil(lambda: not owner.children())
    assert got == [] and not len(model.changed)
    bridge.close()
    bridge.call(lambda: got.append(4))


def test_a_bridge_that_was_deleted_with_its_parent_can_be_closed(owner):
    model = Model()
    bridge = Bridge(owner)
    bridge.bind(model.changed, print)
    sip.delete(owner)
    bridge.close()
    assert not len(model.changed)

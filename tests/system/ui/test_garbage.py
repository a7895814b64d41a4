"""Garbage is collected in the GUI thread, whichever thread makes it."""

import gc
import threading

import pytest
from PyQt5.QtCore import QObject

from grabbergui.ui.garbage import GuiThreadCollector


class Cycle:
    """Refers to itself, and notes which thread collects it."""

    def __init__(self, collected_by):
        self.itself = self
        self._collected_by = collected_by

    def __del__(self):
        self._collected_by.append(threading.current_thread())


@pytest.fixture
def collector(qapp):
    """A collector of its own, after which collection is as it was."""
    automatic = gc.isenabled()
    parent = QObject()
    yield GuiThreadCollector(parent)
    del parent
    (gc.enable if automatic else gc.disable)()


def test_the_cycles_of_a_worker_thread_are_collected_in_the_gui_thread(collector, qtbot):
    collected_by = []

    def work():
        for _ in range(2 * gc.get_threshold()[0]):
            Cycle(collected_by)

    worker = threading.Thread(target=work)
    worker.start()
    worker.join()
    assert not collected_by
    qtbot.waitUntil(lambda: bool(collected_by))
    assert set(collected_by) == {threading.main_thread()}


def test_old_cycles_are_collected_once_long_lived_objects_have_grown(collector):
    collected_by = []
    old = Cycle(collected_by)
    gc.collect()  # `old` belongs to the oldest generation from here on
    del old
    kept = []
    for _ in range(200):
        kept.append([[] for _ in range(20 * gc.get_threshold()[0])])
        collector.collect()
        if collected_by:
            break
    assert collected_by == [threading.main_thread()]


def test_collection_is_automatic_again_without_the_application(qapp):
    automatic = gc.isenabled()
    try:
        parent = QObject()
        GuiThreadCollector(parent)
        assert not gc.isenabled()
        del parent
        assert gc.isenabled()
    finally:
        (gc.enable if automatic else gc.disable)()

"""pytest-qt's robot, as patient as all other tests."""

from pytestqt.qtbot import QtBot

from patience import PATIENCE


class PatientBot(QtBot):
    """As patient as every other test, and keeps its widgets until the test ends.

    pytest-qt refers to a widget weakly. One that the garbage collector takes while Qt is in an event of its
    child ends the process with a segmentation fault.
    """

    def __init__(self, request):
        super().__init__(request)
        self._kept = []

    def addWidget(self, widget, **options):
        super().addWidget(widget, **options)
        self._kept.append(widget)

    def waitUntil(self, callback, *, timeout=int(1000 * PATIENCE)):
        super().waitUntil(callback, timeout=timeout)

    def waitSignal(self, signal, **options):
        return super().waitSignal(signal, **{"timeout": int(1000 * PATIENCE), **options})

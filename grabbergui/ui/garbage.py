"""Python's garbage, collected in the GUI thread."""

from __future__ import annotations

import gc

from PyQt5.QtCore import QObject, QTimer

COLLECTION_PERIOD_MS = 200
"Milliseconds between two looks at how much was allocated."
GROWTH = 1.25
"""Factor by which the number of long-lived objects must grow before all of them are searched, which takes
tens of milliseconds. Python's own rule."""


class GuiThreadCollector(QObject):
    """Replaces automatic garbage collection by one in the GUI thread, as long as `parent` exists.

    Python collects reference cycles on whichever thread happens to allocate. A cycle may contain Qt objects,
    whose destructors must run in the GUI thread: elsewhere they race with it, and the process ends with a
    segmentation fault. This collector needs the thread's event loop, and keeps to Python's own thresholds.
    """

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._long_lived = _count_long_lived()
        timer = QTimer(self)
        timer.timeout.connect(self.collect)
        timer.start(COLLECTION_PERIOD_MS)
        gc.disable()
        parent.destroyed.connect(gc.enable)

    def collect(self) -> None:
        """Collect what has exceeded its threshold."""
        count, threshold = gc.get_count(), gc.get_threshold()
        if count[0] <= threshold[0]:
            return
        if count[1] <= threshold[1]:
            gc.collect(0)
        elif count[2] <= threshold[2] or _count_long_lived() < GROWTH * self._long_lived:
            gc.collect(1)
        else:
            gc.collect(2)
            self._long_lived = _count_long_lived()


def _count_long_lived() -> int:
    return len(gc.get_objects(generation=2))

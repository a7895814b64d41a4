"""Python's garbage collector, confined to the GUI thread.

Python collects reference cycles on whichever thread happens to allocate. A cycle may contain Qt objects,
whose destructors must run in the GUI thread: elsewhere they race with it, and the process ends with a
segmentation fault.
"""

from __future__ import annotations

import gc

from PyQt5.QtCore import QObject, QTimer

PERIOD_MS = 200
"Milliseconds between two looks at how much was allocated."
GROWTH = 1.25
"""Factor by which the number of long-lived objects must grow before all of them are searched, which takes
tens of milliseconds. Python's own rule."""


class GuiThreadCollector(QObject):
    """Replaces automatic collection by one in the thread of `parent`, as long as `parent` exists.

    It needs the thread's event loop, and collects by Python's own thresholds.
    """

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._long_lived = _count_long_lived()
        timer = QTimer(self)
        timer.timeout.connect(self.collect)
        timer.start(PERIOD_MS)
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

"""*Image → Frames to record*: all, every n-th, or a time-lapse."""

from __future__ import annotations

from PyQt5.QtCore import QObject, Qt
from PyQt5.QtWidgets import QAction, QActionGroup, QInputDialog, QMenu

from grabbergui.models.language import localized
from grabbergui.recording.thinning import ALL_FRAMES, Thinning
from grabbergui.ui.shown_text import input_box
from grabbergui.ui.views.recording_bars import RecordingBar

MOST_FRAMES, MOST_SECONDS = 1_000_000, 86_400.0
_FIRST_EVERY, _FIRST_INTERVAL = 10, 5.0
"The first proposal."


class FramesToRecordController(QObject):
    """Asks for the number or the time, and shows the choice beside *Record*."""

    def __init__(self, menu: QMenu, bar: RecordingBar) -> None:
        super().__init__(menu)
        self._bar = bar
        self.thinning = ALL_FRAMES
        """The frames that the next recording has."""
        self.question: QInputDialog | None = None
        """The question for the number or the time, while it is open."""
        group = QActionGroup(self)
        self.all = QAction(self.tr("&All frames"), group)
        self.every = QAction(self.tr("&Every n-th frame…"), group)
        self.lapse = QAction(self.tr("&Time-lapse…"), group)
        for action in group.actions():
            action.setCheckable(True)
        self.all.setChecked(True)
        menu.addActions(group.actions())
        self.all.triggered.connect(lambda: self._choose(ALL_FRAMES))
        self.every.triggered.connect(self._ask_every)
        self.lapse.triggered.connect(self._ask_interval)

    def _ask_every(self) -> None:
        box = self._ask(self.tr("Record one of so many frames:"))
        box.setInputMode(QInputDialog.InputMode.IntInput)
        box.setIntRange(2, MOST_FRAMES)
        box.setIntValue(self.thinning.every if self.thinning.every > 1 else _FIRST_EVERY)
        box.intValueSelected.connect(lambda every: self._choose(Thinning(every=every)))
        box.open()

    def _ask_interval(self) -> None:
        box = self._ask(self.tr("Record a frame every so many seconds:"))
        box.setInputMode(QInputDialog.InputMode.DoubleInput)
        box.setDoubleRange(0.1, MOST_SECONDS)
        box.setDoubleDecimals(1)
        box.setDoubleValue(self.thinning.interval or _FIRST_INTERVAL)
        box.doubleValueSelected.connect(lambda interval: self._choose(Thinning(interval=interval)))
        box.open()

    def _ask(self, text: str) -> QInputDialog:
        self.question = box = input_box(self._bar.window(), self.tr("Frames to record"), text)
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        box.finished.connect(self._on_question_finished)
        return box

    def _on_question_finished(self, _: int) -> None:
        self.question = None
        self._show()

    def _choose(self, thinning: Thinning) -> None:
        self.thinning = thinning
        self._show()

    def _show(self) -> None:
        """Mark what is chosen: a cancelled question leaves the choice as it was."""
        chosen, text = self.all, ""
        if self.thinning.interval:
            chosen, text = self.lapse, localized(f"{self.thinning.interval:g} s")
        elif self.thinning.every > 1:
            chosen, text = self.every, f"1/{self.thinning.every}"
        chosen.setChecked(True)
        self._bar.setThinning(text)

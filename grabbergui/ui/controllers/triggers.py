"""The bar of the current source's trigger."""

from __future__ import annotations

from PyQt5.QtCore import QObject, QTimer

from grabbergui.models.triggers import Triggers
from grabbergui.ui.controllers.source_context import SourceContext
from grabbergui.ui.views.trigger_bar import TriggerBar

PERIOD_MS = 200
"Milliseconds between two readings of the model."


class TriggerController(QObject):
    """Shows the trigger of the current source several times a second, and sends triggers."""

    def __init__(self, bar: TriggerBar, context: SourceContext, triggers: Triggers) -> None:
        super().__init__(context.window)
        self._bar, self._open_sources, self._triggers = bar, context.open_sources, triggers
        bar.sendRequested.connect(self._on_bar_send_requested)
        bar.repeatRequested.connect(self._on_bar_repeat_requested)
        bar.offRequested.connect(self._on_bar_off_requested)
        self._timer = QTimer(self)
        self._timer.setInterval(PERIOD_MS)
        self._timer.timeout.connect(self._refresh)
        self._timer.start()

    def _refresh(self) -> None:
        self._triggers.refresh()
        self._bar.setState(self._triggers.of(self._open_sources.current))

    def _on_bar_send_requested(self) -> None:
        if (source := self._open_sources.current) is not None:
            self._triggers.send(source)

    def _on_bar_repeat_requested(self, period: float) -> None:
        if (source := self._open_sources.current) is not None:
            self._triggers.repeat(source, period)

    def _on_bar_off_requested(self) -> None:
        if (source := self._open_sources.current) is not None:
            self._triggers.switch_off(source)

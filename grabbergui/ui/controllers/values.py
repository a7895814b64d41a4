"""Joins the plots of values over time to the camera."""

from __future__ import annotations

import math
import time
from pathlib import Path

from PyQt5.QtCore import QObject

from grabbergui.core.features import FeatureDescription
from grabbergui.models.connection import Connection
from grabbergui.models.features.value_watch import MOST_FEATURES, ValueHistory, ValueWatch, to_csv
from grabbergui.models.messages import CurrentMessages
from grabbergui.models.open_source import OpenSource
from grabbergui.ui.bridge import Bridge
from grabbergui.ui.views.bases import Dock, FileQuestions
from grabbergui.ui.views.values_panel import ValuesPanel


class ValuesController(QObject):
    """Reads the plotted features while the plots are visible, and nothing otherwise."""

    def __init__(
        self,
        panel: ValuesPanel,
        dock: Dock,
        files: FileQuestions,
        connection: Connection,
        messages: CurrentMessages,
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self._panel = panel
        self._dock = dock
        self._files = files
        self._messages = messages
        self._connection = connection
        self._watch = ValueWatch()
        self._histories: dict[str, ValueHistory] = {}
        self._seen = False
        bridge = Bridge(self)
        bridge.bind(connection.opened, self._on_connection_opened)
        bridge.bind(self._watch.sampled, self._on_sampled)
        # Not over the bridge: nothing more is to be asked of a grabber that is about to be closed.
        connection.closing.connect(self._on_connection_closing, check_nargs=False)
        dock.visibilityChanged.connect(self._on_dock_seen)
        self._panel.removed.connect(self.remove)
        self._panel.pauseToggled.connect(self._update)
        self._panel.clearRequested.connect(self._clear)
        self._panel.saveRequested.connect(self._ask_save)
        self._panel.spanChanged.connect(self._show)

    @property
    def names(self) -> tuple[str, ...]:
        """The plotted features."""
        return self._watch.names

    def plot(self, description: FeatureDescription) -> None:
        """Plot one more value, where it can be seen."""
        if self._watch.full and description.name not in self.names:
            text = self.tr("no more than {0} values can be plotted at once; remove one first")
            self._messages.error(text.format(MOST_FEATURES))
            return
        self._panel.addCurve(description)
        self._histories.setdefault(description.name, ValueHistory())
        self._watch.add(description.name)
        self._dock.show()
        self._dock.raise_()

    def remove(self, name: str) -> None:
        """Plot one value less."""
        self._watch.remove(name)
        self._histories.pop(name, None)
        self._panel.removeCurve(name)

    def save(self, path: Path) -> None:
        """Save everything that was read as comma-separated values, the time in UTC."""
        try:
            path.write_text(to_csv(self._histories), encoding="utf-8")
        except OSError as error:
            self._messages.error(
                self.tr("{0} could not be written: {1}").format(path, error.strerror or error)
            )
        else:
            self._messages.notice(self.tr("Saved the values to {0}").format(path))

    # -- what is read ------------------------------------------------------------------------------
    def _on_connection_opened(self, source: OpenSource) -> None:
        if source is not self._connection.source or source.grabber is None or source.features is None:
            return
        for name in self.names:
            if source.features.description(name) is None:
                self.remove(name)
        self._break()
        self._watch.attach(source.grabber, source.worker)

    def _on_connection_closing(self, _: OpenSource) -> None:
        self._watch.detach()

    def _on_dock_seen(self, seen: bool) -> None:
        self._seen = seen
        self._update()

    def _update(self) -> None:
        wanted = self._seen and not self._panel.pauseButton.isChecked()
        if wanted:
            self._break()
        self._watch.want(wanted)

    def _on_sampled(self, moment: float, values: dict[str, float], units: dict[str, str]) -> None:
        self._panel.setUnits(units)
        for name, value in values.items():
            if (history := self._histories.get(name)) is not None:
                history.add(moment, value)
        self._show(moment)

    # -- what is shown -----------------------------------------------------------------------------
    def _show(self, now: float | None = None) -> None:
        self._panel.setSamples(self._histories, time.time() if now is None else now)

    def _break(self) -> None:
        """Nothing is known of the time in between: the curves must not pretend."""
        for history in self._histories.values():
            if len(history):
                history.add(time.time(), math.nan)

    def _clear(self) -> None:
        self._histories = {name: ValueHistory() for name in self._histories}
        self._show()

    def _ask_save(self) -> None:
        kinds = self.tr("Comma-separated values (*.csv)")
        if path := self._files.to_save(self.tr("Save values"), "values.csv", kinds):
            self.save(path)

"""Joins the picture, the status bar and the acquisition's actions to the models."""

from __future__ import annotations

import time
from pathlib import Path

from PyQt5.QtCore import QObject, QTimer, pyqtSignal

from grabbergui.core.errors import PixelFormatError
from grabbergui.core.grabber import StreamStatistics
from grabbergui.core.pixels import value_at
from grabbergui.models.connection import Connection
from grabbergui.models.diagnosis import CameraFacts, Observation, Stage, diagnose
from grabbergui.models.open_source import LinkState, OpenSource
from grabbergui.models.picture.picture import Picture, PictureModel
from grabbergui.models.picture.pixel_texts import value_texts
from grabbergui.models.recording.snapshot import SnapshotWriter
from grabbergui.ui.bridge import Bridge
from grabbergui.ui.preferences import Preferences
from grabbergui.ui.views.main_window import MainWindow
from grabbergui.ui.widgets.pixel_values import LEGIBLE_ZOOM
from grabbergui.ui.widgets.status_strip import StateTone

STATUS_INTERVAL_MS = 200
FACTS_INTERVAL = 1.0
"Seconds between two questions to a camera that shows no picture."
STALLED = 1.0
"Seconds without a frame after which the state says so."


class AcquisitionController(QObject):
    """Shows the live picture and how it is doing; starts, stops, takes snapshots."""

    failed = pyqtSignal(str)
    """What did not work, for the window's error bar."""

    def __init__(
        self,
        window: MainWindow,
        connection: Connection,
        picture: PictureModel,
        snapshots: SnapshotWriter,
        preferences: Preferences,
    ) -> None:
        super().__init__(window)
        self._window = window
        self._view = window.picture
        self._connection = connection
        self._picture = picture
        self._snapshots = snapshots
        self._preferences = preferences
        self._facts = CameraFacts()
        self._mean: float | None = None
        self._painted = 0
        self._ask_again = 0.0
        self._shown: OpenSource | None = None
        self._shown_since = 0.0
        "`time.monotonic` when it came to hand."
        self._bind_models()
        self._bind_view()
        self._timer = QTimer(self)
        self._timer.setInterval(STATUS_INTERVAL_MS)
        self._timer.timeout.connect(self._refresh)
        self._timer.start()
        self._show_state()

    def _bind_models(self) -> None:
        bridge = Bridge(self)
        bridge.bind(self._picture.ready, self._on_picture_ready)
        bridge.bind(self._connection.opened, self._on_connection_opened)
        bridge.bind(self._connection.state_changed, self._on_connection_state_changed)
        bridge.bind(self._snapshots.saved, self._on_snapshot_saved)
        bridge.bind(self._snapshots.failed, self.failed.emit)
        # Not over the bridge: the queue must be let go before the grabber is closed.
        self._connection.closing.connect(self._on_connection_closing, check_nargs=False)
        self._bridge = bridge

    def _bind_view(self) -> None:
        window, view = self._window, self._view
        window.actionStart.triggered.connect(self._connection.start)
        window.actionStop.triggered.connect(self._connection.stop)
        window.actionSnapshot.triggered.connect(self.snapshot)
        view.viewChanged.connect(self._picture.look_at)
        view.cursorMoved.connect(self._show_cursor)
        view.cursorLeft.connect(self._show_cursor)
        view.painted.connect(self._on_view_painted)

    def snapshot(self) -> None:
        """Save the newest frame where snapshots go."""
        frame, source = self._picture.frame, self._connection.source
        if frame is None or source is None or source.grabber is None:
            self.failed.emit(self.tr("there is no frame yet to take a snapshot of; start the camera first"))
            return
        self._snapshots.save(frame, self._preferences.snapshot_folder, source.grabber.info)

    # -- the picture ---------------------------------------------------------------------------------
    def _on_picture_ready(self) -> None:
        picture = self._picture.take()
        if picture is None or self._shown is None:
            return
        self._view.setPicture(picture.image, picture.width, picture.height)
        self._show_values(picture)
        # Every tenth line and column is plenty to tell black from not black.
        self._mean = float(picture.image.pixels[::10, ::10].mean())

    def _show_values(self, picture: Picture) -> None:
        """Write the sensor's values on pixels that have room for them."""
        canvas, texts = self._view.canvas, {}
        if canvas.zoom >= LEGIBLE_ZOOM * canvas.devicePixelRatioF():
            texts = value_texts(picture.frame, picture.image.region, self._picture.settings.orientation)
        canvas.values.setTexts(texts)

    def _on_view_painted(self) -> None:
        self._painted += 1
        self._picture.painted()

    def _show_cursor(self, *_: int) -> None:
        frame, pixel = self._picture.frame, self._view.canvas.cursorPixel
        if frame is None or pixel is None or self._shown is None:
            self._view.setCursorText("")
            return
        pixel = self._picture.settings.orientation.pixel(*pixel, frame.width, frame.height)
        try:
            values = value_at(frame, *pixel)
        except (PixelFormatError, IndexError):
            self._view.setCursorText(f"x {pixel[0]}  y {pixel[1]}")
            return
        text = ", ".join(str(value) for value in values)
        self._view.setCursorText(f"x {pixel[0]}  y {pixel[1]}   {frame.pixel_format.family.value} {text}")

    # -- the connection --------------------------------------------------------------------------------
    def _on_connection_opened(self, source: OpenSource) -> None:
        if source is not self._connection.source or source.grabber is None:
            return
        self._shown, self._shown_since = source, time.monotonic()
        self._forget()
        self._picture.attach(source.grabber)

    def _on_connection_closing(self, _: OpenSource) -> None:
        self._picture.detach()

    def _on_connection_state_changed(self, state: LinkState, _: str) -> None:
        if state in (LinkState.CLOSED, LinkState.OPENING):
            self._shown = None
            self._view.clear()
            self._window.status.clearFigures()
        if state is LinkState.STREAMING:
            self._forget()
            self._picture.restarted()
        self._refresh()

    def _forget(self) -> None:
        self._facts = CameraFacts()
        self._mean = None
        self._painted = 0
        self._ask_again = 0.0

    def _on_snapshot_saved(self, path: Path) -> None:
        self._window.messages.showNotice(self.tr("Saved {0}").format(path))

    # -- how it is doing ---------------------------------------------------------------------------------
    def _refresh(self) -> None:
        self._show_state()
        source = self._shown
        if source is None or source.grabber is None:
            self._view.setNote(*self._invitation())
            return
        statistics = source.grabber.statistics()
        self._show_figures(statistics)
        self._show_cursor()
        if self._window.actionPause.isChecked():
            self._view.setNote("")
        elif self._connection.state is LinkState.STREAMING:
            self._explain(source, statistics)
        elif source.no_picture:
            self._view.setNote(
                self.tr("The picture goes to the program that has control."), source.no_picture, Stage.PACKETS
            )
        else:
            self._view.setNote("")

    def _invitation(self) -> tuple[str, str]:
        """What to say where there is nothing to see: a sentence, and what to do."""
        if self._connection.state is LinkState.OPENING:
            source = self._connection.source
            return self.tr("Connecting to {0} …").format(source.uri if source is not None else ""), ""
        return (
            self.tr("Nothing is connected."),
            self.tr("Choose a source on the left, or type its address; sim: is the simulated camera."),
        )

    def _show_figures(self, statistics: StreamStatistics) -> None:
        status, frame = self._window.status, self._picture.frame
        if frame is not None and self._picture.last_received is not None:
            status.setFormat(f"{frame.width} × {frame.height}  {frame.pixel_format}")
        if self._connection.state is LinkState.STREAMING:
            status.setRates(statistics.frame_rate, self._picture.painted_rate)
            status.setBandwidth(statistics.bandwidth)
        else:  # what is remembered of the last second would pass for something that goes on
            status.setRates(0, 0)
            status.setBandwidth(0)
        status.setLosses(statistics.lost, statistics.incomplete)

    def _explain(self, source: OpenSource, statistics: StreamStatistics) -> None:
        assert source.grabber is not None
        seen = Observation(
            source=source.title,
            address=source.grabber.info.address,
            bus=source.grabber.info.bus,
            seconds=self._since_start(source),
            silent=self._silent(source),
            statistics=statistics,
            received=self._picture.received,
            problem=self._picture.problem,
            painted=self._painted,
            mean=self._mean,
            facts=self._facts,
        )
        found = diagnose(seen)
        if found is None:
            self._view.setNote("")
            return
        self._view.setNote(found.summary, found.advice, found.stage)
        self._ask_for_facts(source)

    def _ask_for_facts(self, source: OpenSource) -> None:
        """Read what bears on it; not while all is well, so that nothing disturbs a running camera."""
        grabber = source.grabber
        if grabber is None or time.monotonic() < self._ask_again:
            return
        self._ask_again = time.monotonic() + FACTS_INTERVAL

        def done(facts: CameraFacts) -> None:
            self._bridge.call(lambda: self._on_facts(source, facts))

        source.worker.submit(lambda: CameraFacts.read(grabber), key="diagnosis", done=done)

    def _on_facts(self, source: OpenSource, facts: CameraFacts) -> None:
        if source is self._shown:
            self._facts = facts

    def _since_start(self, source: OpenSource) -> float:
        if source.streaming_since is None:
            return 0.0
        return time.monotonic() - max(source.streaming_since, self._shown_since)

    def _silent(self, source: OpenSource) -> float:
        last = self._picture.last_received
        return time.monotonic() - last if last is not None else self._since_start(source)

    def _show_state(self) -> None:
        state, source = self._connection.state, self._connection.source
        status, window = self._window.status, self._window
        if state is LinkState.STREAMING and source is not None:
            silent = self._silent(source)
            if self._window.actionPause.isChecked():
                status.setState(self.tr("Paused"), StateTone.BUSY)
            elif silent < STALLED:
                status.setState(self.tr("Live"), StateTone.GOOD)
            elif self._picture.last_received is None:
                status.setState(self.tr("Waiting for a frame, {0:.0f} s").format(silent), StateTone.BUSY)
            else:
                status.setState(self.tr("Stalled for {0:.0f} s").format(silent), StateTone.BUSY)
        else:
            text, tone = {
                LinkState.CLOSED: (self.tr("Not connected"), StateTone.IDLE),
                LinkState.OPENING: (self.tr("Connecting"), StateTone.BUSY),
                LinkState.LOST: (self.tr("Connection lost"), StateTone.BAD),
            }.get(state, (self.tr("Stopped"), StateTone.IDLE))
            if source is not None and source.read_only and state is LinkState.OPEN:
                text = self.tr("Read only")
            status.setState(text, tone)
        status.setMessage(source.title if source is not None else "")
        window.actionConnect.setEnabled(state in (LinkState.CLOSED, LinkState.LOST))
        window.actionDisconnect.setEnabled(state is not LinkState.CLOSED)
        window.actionStart.setEnabled(state is LinkState.OPEN)
        window.actionStop.setEnabled(state is LinkState.STREAMING)
        window.actionSnapshot.setEnabled(self._shown is not None and self._picture.frame is not None)

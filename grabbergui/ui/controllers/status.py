"""How the current source is doing: the status strip."""

from __future__ import annotations

import time

from PyQt5.QtCore import QObject, QTimer, pyqtSignal

from grabbergui.models.diagnosis import Diagnosis, Stage, StreamObservation, diagnose
from grabbergui.models.messages import Cause, MessageModel, Offer, Severity, UserMessage
from grabbergui.models.open_source import OpenSource
from grabbergui.models.other_program import holder_name
from grabbergui.models.status import MOST_STEP, Condition, SourceStatus, StatusModel
from grabbergui.ui.controllers.source_context import SourceContext
from grabbergui.ui.gui_thread import Bridge
from grabbergui.ui.views.bases import LiveImageView, StatusView

STATUS_PERIOD_MS = 200
"Milliseconds between two readings of the models."
_RUNNING = (Condition.STARTING, Condition.LIVE, Condition.PLAYING, Condition.STALLED)
"Conditions in which images are expected."


class StatusController(QObject):
    """Reads the models several times a second, and updates the views."""

    titleChanged = pyqtSignal(str)
    """The window's title, without the program's name."""
    lockChanged = pyqtSignal(str)
    """Why no feature can be written now; empty if they can."""
    simulationRequested = pyqtSignal()
    """The simulated camera is wanted in the empty window."""
    addressRequested = pyqtSignal()
    """An address is to be typed."""
    doctorRequested = pyqtSignal()
    """A camera is missing, and the user wants to know why."""

    def __init__(
        self,
        strip: StatusView,
        view: LiveImageView,
        context: SourceContext,
        status: StatusModel,
        messages: MessageModel,
    ) -> None:
        super().__init__(context.window)
        self._strip = strip
        self._view = view
        self._open_sources = context.open_sources
        self._image = context.image
        self._status = status
        self._messages = messages
        self._beginnings = (
            Offer(self.tr("Simulated camera"), self.simulationRequested.emit),
            Offer(self.tr("Type an address"), self.addressRequested.emit),
            Offer(self.tr("Why is mine missing?"), self.doctorRequested.emit),
        )
        self._shown: OpenSource | None = None
        self._unpainted = 0.0
        "Seconds for which frames have reached the window without any having been painted."
        self._looked = time.monotonic()
        self._title = self._lock = ""
        bridge = Bridge(self)
        bridge.bind(messages.changed, self._show_messages)
        bridge.bind(context.open_sources.state_changed, lambda *_: self.refresh())
        bridge.bind(context.open_sources.changed, lambda _: self.refresh())
        self._timer = QTimer(self)
        self._timer.setInterval(STATUS_PERIOD_MS)
        self._timer.timeout.connect(self.refresh)
        self._timer.start()
        self.refresh()

    def refresh(self) -> None:
        """Read everything now."""
        source = self._open_sources.current
        now = time.monotonic()
        step, self._looked = min(now - self._looked, MOST_STEP), now
        if source is not self._shown:
            self._shown = source
            self._strip.clearFigures()
        self._unpainted = self._unpainted + step if self._image.received and self._view.empty else 0.0
        self._status.refresh()
        status = self._status.of(source)
        self._strip.setState(status.text, status.tone)
        self._strip.setTitle(*(source.names if source is not None else ("",)))
        self._show_title(source, status)
        self._show_lock(status)
        if source is not None:
            self._show_figures(status)
        self._explain(source, status)
        self._show_age(status)
        self._messages.expire()
        self._show_messages()

    def _show_messages(self) -> None:
        self._strip.setMessages(self._messages.shown(self._open_sources.current))

    def _show_title(self, source: OpenSource | None, status: SourceStatus) -> None:
        title = status.title(source.title) if source is not None else ""
        if title != self._title:
            self._title = title
            self.titleChanged.emit(title)

    def _show_lock(self, status: SourceStatus) -> None:
        lock = ""
        if status.condition is Condition.LOST:
            lock = self.tr("The camera does not answer; its last known settings are shown until it is back.")
        if lock != self._lock:
            self._lock = lock
            self.lockChanged.emit(lock)

    def _show_figures(self, status: SourceStatus) -> None:
        statistics, frame = status.statistics, self._image.frame
        if statistics is None:
            return
        known = f"{frame.width} × {frame.height}  {frame.pixel_format}" if frame is not None else ""
        self._strip.setFormat(known)
        self._strip.setSaturated(self._image.saturated)
        running = status.condition in (*_RUNNING, Condition.PAUSED, Condition.WAITING)
        # The state of the last second would look current.
        self._strip.setRates(*((statistics.frame_rate, self._image.painted_rate) if running else (0, 0)))
        self._strip.setBandwidth(statistics.bandwidth if running else 0)
        self._strip.setLosses(status.health.text, status.loss_tone, status.health.detail)

    def _show_age(self, status: SourceStatus) -> None:
        """Note on the last image of a source that is lost."""
        last = self._image.last_received
        lost = status.condition is Condition.LOST and last is not None
        self._view.setAge(time.monotonic() - last if lost and last is not None else None)

    def _explain(self, source: OpenSource | None, status: SourceStatus) -> None:
        """Explain a missing image: in the middle of an empty view, else in a message."""
        note = self._note(source, status)
        if self._view.empty:
            self._view.setNote(*note, self._beginnings if source is None else ())
        else:
            self._view.setNote("")
        summary, advice, stage = note
        if source is None:
            return
        if stage is None or self._view.empty:
            self._messages.end(source, Cause.IMAGE)
        else:
            text = f"{summary} {advice}".strip()
            self._messages.post(UserMessage(text, Severity.WARNING, source, Cause.IMAGE))

    def _note(self, source: OpenSource | None, status: SourceStatus) -> tuple[str, str, Stage | None]:
        """Return the note on a missing image: its reason, the remedy, and the stage at which it is lost."""
        condition = status.condition
        if source is None:
            return (
                self.tr("Nothing is connected."),
                self.tr("Choose one of the sources (F8), or begin here:"),
                None,
            )
        if condition is Condition.CONNECTING:
            return self.tr("Connecting to {0} …").format(source.uri), "", None
        if condition is Condition.WAITING:
            return self.tr("Waiting for a trigger"), "", None
        if condition is Condition.READ_ONLY and source.no_frames:
            holder = holder_name(source.denied)
            summary = self.tr("The image goes to the program that has control.")
            if holder:
                summary = self.tr("The image goes to the program that has control: {0}.").format(holder)
            return summary, source.no_frames, Stage.CONTROL
        found = self._diagnosis(source, status) if condition in _RUNNING else None
        return (found.summary, found.advice, found.stage) if found is not None else ("", "", None)

    def _diagnosis(self, source: OpenSource, status: SourceStatus) -> Diagnosis | None:
        if source.grabber is None or status.statistics is None:
            return None
        return diagnose(
            StreamObservation(
                source=source.title,
                address=source.grabber.info.address,
                bus=source.grabber.info.bus,
                unpainted=self._unpainted,
                silent=status.seconds,
                statistics=status.statistics,
                problem=self._image.problem,
                mean=self._image.mean,
                facts=status.facts,
                silence=source.grabber.silence(),
            )
        )

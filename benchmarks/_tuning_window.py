"""Runs the window of `tuning` in a process of its own, operates its controls and observes its image."""

from __future__ import annotations

import os
import random
import statistics
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from multiprocessing.connection import Connection

from PyQt5.QtCore import QEvent, QEventLoop, QPoint, QPointF, Qt, QTimer
from PyQt5.QtGui import QKeyEvent, QWheelEvent
from PyQt5.QtWidgets import QApplication, QWidget

from benchmarks._network_ends import cpu_seconds
from benchmarks._tuning_cameras import SOURCES, Tuned, level_of
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.pixels import DisplayImage
from grabbergui.models.open_source import LinkState
from grabbergui.net.remote_grabber import RemoteGrabber
from grabbergui.net.tree import TreeFeatures
from grabbergui.ui.editors.number_editors import RangeEditor
from grabbergui.ui.run.program import Program

PATIENCE = 30.0
PAUSE = 0.12
"Least pause between two adjustments in seconds; a random one up to as long is added."
AFTERWARDS = 0.05
"Seconds of the pause that follow the adjustment, in the event loop."
KEY_DOWN = 0.03
"Seconds that a key stays down."
YARDSTICKS = 40
"Number of reference writes and requests of each kind, with the same pauses."
DRAG_SECONDS, DRAG_RATE = 5.0, 60.0
HANDS = ("slider", "key", "wheel", "typed")


@dataclass(frozen=True)
class Adjusted:
    """Delays of one adjustment, seconds from the control's signal."""

    register: float
    image: float | None
    "To the first painted image that shows it; None if images do not show the value."


@dataclass(frozen=True)
class Dragged:
    """A slider dragged for a while."""

    signals: int
    writes: int
    last: float
    "Seconds from the last signal to its value in the register."
    lags: list[float]
    "Seconds from each signal to the next write."
    images: list[float]
    "Age of the value that each image shows when it is painted, seconds."
    cores: float
    painted: float
    "Painted images per second meanwhile."


@dataclass
class Seen:
    """The measurements of one source."""

    adjusted: dict[str, list[Adjusted]] = field(default_factory=dict)
    dragged: Dragged | None = None
    frame_period: float = 0.0
    own_write: float = 0.0
    round_trip: float = 0.0
    driver_write: list[float] = field(default_factory=list)
    "Seconds of the driver's `write_feature`, without a window."


class Eye:
    """Records the brightness of each painted image, and the time."""

    def __init__(self, program: Program) -> None:
        image = program.window.image
        self.painted: list[tuple[float, float]] = []
        self._brightness = 0.0
        self._show = image.canvas.setImage
        image.canvas.setImage = self._set_image  # type: ignore[method-assign]
        image.painted.connect(self._on_painted)

    def _set_image(self, image: DisplayImage, width: int, height: int) -> None:
        self._brightness = float(image.pixels[::32, ::32].max())
        self._show(image, width, height)

    def _on_painted(self) -> None:
        self.painted.append((time.monotonic(), self._brightness))


def watch(pipe: Connection, source: str, repeats: int) -> None:
    """Open the window on a source, adjust a feature by every control, and send the results as `Seen`."""
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    with SOURCES[source]() as tuned:
        pipe.send(_Operator(tuned).measure(repeats))


class _Operator:
    def __init__(self, tuned: Tuned) -> None:
        from grabbergui.ui.application import application
        from grabbergui.ui.preferences import Preferences
        from grabbergui.ui.theme import Theme, dress
        from grabbergui.ui.views.main_window import MainWindow

        self.tuned = tuned
        self.app = application()
        dress(self.app, Theme.LIGHT)
        self.window = MainWindow()
        self.window.resize(1600, 1000)
        self.program = Program(self.window, Preferences(None), tuned.create)
        self.eye = Eye(self.program)
        self.window.show()
        self.window.activateWindow()

    def measure(self, repeats: int) -> Seen:
        seen = Seen()
        try:
            self.program.begin(self.tuned.uri)
            self._until(lambda: self.program.open_sources.state is LinkState.STREAMING, "the stream")
            self._until(lambda: len(self.eye.painted) > 30, "thirty images")
            self._open_panel()
            seen.frame_period = self._frame_period()
            for hand in HANDS:
                seen.adjusted[hand] = self._adjust(hand, repeats)
            seen.dragged = self._drag()
            seen.round_trip = self._round_trip()
            seen.driver_write = self._driver_writes()
            seen.own_write = self.tuned.own_write()
        finally:
            self.window.close()
            self.program.shut_down(10)
            self.program.open_sources.wait_closed(10)
        return seen

    def _open_panel(self) -> None:
        """Show every feature of the first ten categories, with the visibility Guru."""
        from grabbergui.ui.views.feature_panel import Section

        panel = self.window.features
        panel.levelBox.setCurrentText("Guru")
        for section in [s for s in panel.findChildren(Section) if not (s.open or s.isHidden())][:10]:
            section.header.click()
            self._wait(0.05)
        self._wait(3.0)

    def _editor(self) -> RangeEditor:
        name = self.tuned.feature
        rows = self.window.favourites.rows.rows(name) or self.window.features.rows.rows(name)
        editor = rows[0].editor
        assert isinstance(editor, RangeEditor), f"{name} has no slider"
        return editor

    def _frame_period(self) -> float:
        before, began = self.program.image.received, time.monotonic()
        self._wait(2.0)
        return (time.monotonic() - began) / max(self.program.image.received - before, 1)

    def _adjust(self, hand: str, repeats: int) -> list[Adjusted]:
        act = getattr(self, f"_by_{hand}")
        self._by_slider(0)
        self._wait(0.5)
        moments: list[float] = []
        for number in range(repeats):
            up = number % 2 == 0
            if hand == "typed":
                self._type("12" if up else "1")
            self._in_the_loop(partial(self._note_and_act, act, up, moments))
        self._wait(0.5)
        return self._results(moments)

    def _in_the_loop(self, move: Callable[[], None]) -> None:
        """Move a control after a while without blocking the event loop."""
        pause = _pause()
        QTimer.singleShot(round((pause - AFTERWARDS) * 1000), Qt.TimerType.PreciseTimer, move)
        self._wait(pause)

    @staticmethod
    def _note_and_act(act: Callable[[bool], None], up: bool, moments: list[float]) -> None:
        moments.append(time.monotonic())
        act(up)

    def _by_slider(self, up: bool | int) -> None:
        slider = self._editor().slider()
        slider.setValue(slider.maximum() // 2 if up else 0)

    def _by_key(self, up: bool) -> None:
        field = self._editor().field
        field.setFocus()
        _press(field, Qt.Key.Key_Up if up else Qt.Key.Key_Down)

    def _by_wheel(self, up: bool) -> None:
        field = self._editor().field
        field.setFocus()
        delta = QPoint(0, 120 if up else -120)
        centre = QPointF(field.rect().center())
        event = QWheelEvent(
            centre,
            QPointF(field.mapToGlobal(field.rect().center())),
            QPoint(),
            delta,
            Qt.MouseButton.NoButton,
            Qt.KeyboardModifier.NoModifier,
            Qt.ScrollPhase.NoScrollPhase,
            False,
        )
        QApplication.sendEvent(field, event)

    def _type(self, digits: str) -> None:
        field = self._editor().field
        field.setFocus()
        field.selectAll()
        for digit in digits:
            _press(field, Qt.Key(ord(digit)), digit)
            self._wait(2 * KEY_DOWN)

    def _by_typed(self, up: bool) -> None:
        _press(self._editor().field, Qt.Key.Key_Return)

    def _results(self, moments: list[float]) -> list[Adjusted]:
        """Return the seconds from each signal to the next write and to the change of the grey value."""
        writes, painted = self.tuned.writes(), self.eye.painted
        found = []
        for moment in moments:
            written = min((at for at in writes if at >= moment), default=float("inf"))
            before = next(level for at, level in reversed(painted) if at < moment)
            seen = min(
                (at for at, level in painted if at >= moment and level != before), default=float("inf")
            )
            found.append(Adjusted(written - moment, seen - moment if self.tuned.shown else None))
        return found

    def _drag(self) -> Dragged:
        slider = self._editor().slider()
        signals: list[float] = []
        levels: list[int] = []
        editor = self._editor()
        editor.valueEdited.connect(lambda value: levels.append(level_of(float(value))))
        before, painted = len(self.tuned.writes()), len(self.eye.painted)
        slider.setSliderDown(True)
        cpu, began = cpu_seconds(), time.monotonic()
        steps = round(DRAG_SECONDS * DRAG_RATE)
        for step in range(steps):
            self._wait(began + step / DRAG_RATE - time.monotonic())
            signals.append(time.monotonic())
            slider.setSliderPosition(1 + step * (slider.maximum() - 1) // steps)
        took, cpu = time.monotonic() - began, cpu_seconds() - cpu
        count = len(self.eye.painted) - painted
        self._wait(1.0)
        slider.setSliderDown(False)
        writes = self.tuned.writes()[before:]
        lags = [
            min((at - signal for at in writes if at >= signal), default=float("inf")) for signal in signals
        ]
        images = self._image_lags(signals, levels) if self.tuned.shown else []
        return Dragged(
            len(signals), len(writes), writes[-1] - signals[-1], lags, images, cpu / took, count / took
        )

    def _image_lags(self, signals: list[float], levels: list[int]) -> list[float]:
        """Return the age of the value that each image shows when it is painted, seconds."""
        found = []
        for at, level in self.eye.painted:
            if signals[0] <= at <= signals[-1]:
                made = [
                    signal for signal, of in zip(signals, levels, strict=True) if signal <= at and of == level
                ]
                found += [at - made[-1]] if made else []
        return found

    def _round_trip(self) -> float:
        """Return the median seconds of an empty request to a remote source; 0 for a local one."""
        grabber = self._grabber()
        features = grabber._known() if isinstance(grabber, RemoteGrabber) else None
        if not isinstance(features, TreeFeatures):
            return 0.0
        took = []
        for _ in range(YARDSTICKS):
            self._wait(_pause())
            began = time.monotonic()
            features._ask("hello")
            took.append(time.monotonic() - began)
        return statistics.median(took)

    def _grabber(self) -> FrameGrabber:
        source = self.program.open_sources.current
        assert source is not None and source.grabber is not None
        return source.grabber

    def _driver_writes(self) -> list[float]:
        """Return the seconds of writes by the driver alone, on a thread of its own as in the window."""
        grabber, name = self._grabber(), self.tuned.feature
        low = grabber.feature(name).minimum or 0

        def write(value: float) -> float:
            began = time.monotonic()
            grabber.write_feature(name, value)
            return time.monotonic() - began

        took = []
        with ThreadPoolExecutor(1) as thread:
            for number in range(YARDSTICKS):
                self._wait(_pause())
                took.append(thread.submit(write, low + number % 2).result())
        return took

    def _wait(self, seconds: float) -> None:
        """Run the event loop for a while."""
        loop = QEventLoop()
        QTimer.singleShot(max(round(seconds * 1000), 0), Qt.TimerType.PreciseTimer, loop.quit)
        loop.exec_()

    def _until(self, condition: Callable[[], object], what: str) -> None:
        deadline = time.monotonic() + PATIENCE
        while not condition():
            if time.monotonic() > deadline:
                said = self.window.messages.messages
                raise SystemExit(f"{self.tuned.uri}: {what} did not come within {PATIENCE:g} s: {said}")
            self._wait(0.01)


def _pause() -> float:
    return PAUSE + random.uniform(0, PAUSE)


def _press(widget: QWidget, key: Qt.Key, text: str = "") -> None:
    """Press a key, and release it a little later."""
    _send_key(widget, QEvent.Type.KeyPress, key, text)
    QTimer.singleShot(round(KEY_DOWN * 1000), partial(_send_key, widget, QEvent.Type.KeyRelease, key, text))


def _send_key(widget: QWidget, kind: QEvent.Type, key: Qt.Key, text: str) -> None:
    QApplication.sendEvent(widget, QKeyEvent(kind, key, Qt.KeyboardModifier.NoModifier, text))

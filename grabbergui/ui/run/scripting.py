"""Runs a user's script with the objects of the window, for example on a robot without a screen.

A script is plain Python and finds one name, `app`. It runs on the GUI thread; whenever it waits, the window
handles its events.
"""

from __future__ import annotations

import time
import traceback
from collections.abc import Callable
from pathlib import Path
from types import CodeType
from typing import Any, TypeVar

from PyQt5.QtCore import QEventLoop, QTimer
from PyQt5.QtWidgets import QWidget

from grabbergui.core.environment import find_file
from grabbergui.core.errors import FrameTimeoutError, GrabberError, UsageError
from grabbergui.core.features import Feature, FeatureValue
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.regular_files import read_bounded
from grabbergui.core.visible_text import print_lines
from grabbergui.models.open_source import LinkState, OpenSource
from grabbergui.ui.run.program import Program
from grabbergui.ui.views.main_window import MainWindow

T = TypeVar("T")

PATIENCE = 10.0
"Seconds that a call waits by default."
EXIT_FAILURE = 1
_POLL_MS = 10
MAX_SCRIPT_BYTES = 16 << 20


class _Ended(BaseException):
    """Ends the script: it called `end`, or the window was closed."""

    def __init__(self, code: int) -> None:
        super().__init__(code)
        self.code = code


class ScriptApi:
    """The object `app` of a script. Calls return when they are done; those that fail raise GrabberError."""

    def __init__(self, program: Program) -> None:
        self.program = program
        "The models and controllers behind the window."
        self.patience = PATIENCE
        "Seconds that a call waits that is given no `timeout`; a script on a slow computer may raise it."
        self._failures: list[str] = []
        self._closed = False
        program.opener.reports.failed.connect(self._failures.append)
        program.window.closing.connect(self._on_window_closing)

    @property
    def window(self) -> MainWindow:
        """The window; its actions and widgets act as they do for the operator."""
        return self.program.window

    @property
    def grabber(self) -> FrameGrabber:
        """The current source. Raises GrabberError if nothing is open."""
        grabber = self._source().grabber
        assert grabber is not None
        return grabber

    @property
    def messages(self) -> list[str]:
        """The messages that the window shows, the newest first."""
        program = self.program
        return [message.text for message in program.messages.shown(program.open_sources.current)]

    def open(self, uri: str, timeout: float | None = None) -> FrameGrabber:
        """Open a source in place of the current one, start it, and return it."""
        del self._failures[:]
        open_sources = self.program.open_sources
        before = open_sources.current
        self.program.opener.connect_to(uri)

        def settled() -> bool:
            if self._failures:
                return True
            ended = (LinkState.STREAMING, LinkState.CLOSED)
            return open_sources.current is not before and open_sources.state in ended

        self.until(settled, timeout, f"{uri} is not open")
        if open_sources.current is before or open_sources.state is not LinkState.STREAMING:
            raise GrabberError(self._failures[0] if self._failures else f"{uri} was closed")
        return self.grabber

    def wait_for_source(self, timeout: float | None = None, *, otherwise: str = "") -> FrameGrabber:
        """Wait until the source that the command line named is open and streams, and return it.

        If it named none, `otherwise` is opened.
        """
        if otherwise and not self.program.named_source:
            return self.open(otherwise, timeout)
        open_sources = self.program.open_sources

        def refusal() -> str:
            """Return why the source did not open, which may have been known before the script began."""
            if self._failures:
                return self._failures[0]
            return open_sources.reason if open_sources.state is LinkState.CLOSED else ""

        self.until(
            lambda: refusal() or open_sources.state is LinkState.STREAMING,
            timeout,
            "the source of the command line is not open",
        )
        if open_sources.state is not LinkState.STREAMING:
            raise GrabberError(refusal())
        return self.grabber

    def close(self, timeout: float | None = None) -> None:
        """Close every source, and wait until they are."""
        self.program.open_sources.close_all()
        self.until(lambda: self.program.open_sources.wait_closed(0), timeout, "a source does not close")

    def get(self, name: str) -> Feature:
        """Read a feature."""
        grabber = self.grabber
        return self._on_source(lambda: grabber.feature(name))

    def set(self, name: str, value: FeatureValue) -> Feature:
        """Write a feature as the operator does, undo included, and return what the camera then reports."""
        grabber = self._source().tracked_grabber
        assert grabber is not None
        return self._on_source(lambda: grabber.write_feature(name, value))

    def execute(self, name: str) -> None:
        """Run a command feature."""
        grabber = self._source().tracked_grabber
        assert grabber is not None
        self._on_source(lambda: grabber.execute(name))

    def wait_for_frames(self, count: int = 1, timeout: float | None = None) -> Frame:
        """Wait for `count` more frames, and return the last. Raises FrameTimeoutError."""
        queue, frame = self.grabber.open_queue(count), None
        try:
            for _ in range(count):
                frame = self._next(queue.get, timeout)
        finally:
            queue.close()
        assert frame is not None, "no frames were asked for"
        return frame

    def until(
        self,
        condition: Callable[[], object],
        timeout: float | None = None,
        otherwise: str = "the condition was not met",
    ) -> None:
        """Wait until a condition is true. Raises GrabberError after `timeout` seconds."""
        timeout = self.patience if timeout is None else timeout
        deadline = time.monotonic() + timeout
        while not condition():
            if time.monotonic() > deadline:
                raise GrabberError(f"{otherwise} after {timeout:g} s")
            self.wait(_POLL_MS / 1000)

    def wait(self, seconds: float) -> None:
        """Let the window handle its events for a while."""
        loop = QEventLoop()
        ended = False

        def end() -> None:
            nonlocal ended
            ended = True
            loop.quit()

        QTimer.singleShot(round(seconds * 1000), end)
        loop.exec_()
        if not ended or self._closed:  # the window was closed, or the program was asked to end
            raise _Ended(EXIT_FAILURE)

    def screenshot(self, path: str | Path, widget: QWidget | None = None) -> Path:
        """Save a screenshot of the window, or of a part of it."""
        path = Path(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        if not (widget or self.window).grab().save(str(path)):
            raise GrabberError(f"the screenshot could not be written to {path}")
        return path

    def end(self, code: int = 0) -> None:
        """End the script and the window here, with this exit code."""
        raise _Ended(code)

    def _source(self) -> OpenSource:
        source = self.program.open_sources.current
        if source is None:
            raise GrabberError("nothing is open; call app.open('sim:') first")
        if source.tracked_grabber is None:
            raise GrabberError(f"{source.uri} is not open yet; call app.wait_for_source() first")
        return source

    def _on_source(self, job: Callable[[], T]) -> T:
        """Run a job on the source's own thread, and wait for its result here."""
        results: list[T] = []
        errors: list[GrabberError] = []
        features = self._source().features
        assert features is not None
        features.run(job, done=results.append, failed=errors.append)
        self.until(lambda: results or errors, None, "the source does not answer")
        if errors:
            raise errors[0]
        return results[0]

    def _next(self, get: Callable[[float], Frame], timeout: float | None) -> Frame:
        timeout = self.patience if timeout is None else timeout
        deadline = time.monotonic() + timeout
        while True:
            try:
                return get(0)
            except FrameTimeoutError:
                if time.monotonic() > deadline:
                    raise FrameTimeoutError(f"no frame within {timeout:g} s") from None
            self.wait(_POLL_MS / 1000)

    def _on_window_closing(self) -> None:
        self._closed = True


def load_script(path: Path) -> CodeType:
    """Read and compile a script, the user's or a shipped one. Raises UsageError."""
    path = find_file(path, "script")
    try:
        return compile(read_bounded(path, MAX_SCRIPT_BYTES, "script"), str(path), "exec")
    except OSError as error:
        raise UsageError(f"the script {path} cannot be read: {error.strerror or error}") from error
    except (SyntaxError, ValueError) as error:
        raise UsageError(f"the script {path} is no Python: {error}") from error


def run_script(script: CodeType, program: Program) -> int:
    """Run a script on the GUI thread, inside the event loop; return its exit code.

    It is 0 after the last line, the script's own if it ended itself, and 1 if it failed, with the script's
    lines of the traceback on stderr, or if the window was closed.
    """
    app = ScriptApi(program)
    names: dict[str, Any] = {"__name__": "__main__", "__file__": script.co_filename, "app": app}
    try:
        exec(script, names)  # the script is the user's own
    except _Ended as ended:
        return ended.code
    except SystemExit as ended:
        return _code(ended)
    except Exception as error:
        _print_traceback(error, script.co_filename)
        return EXIT_FAILURE
    return 0


def _code(ended: SystemExit) -> int:
    """Return the exit code as Python reads it: from a number, nothing, or a text for stderr."""
    if ended.code is None or isinstance(ended.code, int):
        return ended.code or 0
    print_lines(str(ended.code).split("\n"), error=True)
    return EXIT_FAILURE


def _print_traceback(error: Exception, script: str) -> None:
    """Print the script's lines that led to an error, without those of the program below."""
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename == script]
    lines = ["Traceback (most recent call last):\n", *traceback.format_list(frames)]
    text = "".join([*lines, *traceback.format_exception_only(type(error), error)])
    print_lines(text.rstrip("\n").split("\n"), error=True)

"""One-push: runs one tuning at a time, and restores what it changed if it fails or is cancelled."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable

from psygnal import Signal

from grabbergui.core.companions import regulating
from grabbergui.core.errors import FeatureNotFoundError, GrabberError
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.sfnc import AUTO_ONCE, Role
from grabbergui.models.changes.history import Step
from grabbergui.models.changes.tracking import NotingGrabber
from grabbergui.models.error_text import error_text
from grabbergui.models.features.text import value_text
from grabbergui.models.features.tree import FeatureTreeModel
from grabbergui.models.language import translate
from grabbergui.models.tuning.parameters import automatic_once
from grabbergui.models.tuning.run import TuningBench, TuningCancelledError, TuningError

log = logging.getLogger(__name__)

Tuning = Callable[[TuningBench], str]
"Tunes a camera and says what came of it; raises GrabberError."


class OnePush:
    """No call waits; signals come from the tuning's thread."""

    progressed = Signal(float, str)
    """How far it is (0 … 1), and where it stands, for people."""
    succeeded = Signal(str)
    """What came of it, for people."""
    failed = Signal(str)
    """Why it came to nothing; everything is as it was, or it says what is not."""
    ended = Signal()
    """Always, at the end."""

    def __init__(self) -> None:
        self._bench: TuningBench | None = None
        self._thread: threading.Thread | None = None

    @property
    def running(self) -> bool:
        """Whether one is under way."""
        return self._bench is not None

    def start(self, name: str, tuning: Tuning, hands: NotingGrabber, features: FeatureTreeModel) -> bool:
        """Begin; `name` is what can be undone later. False where one is under way already."""
        if self._bench is not None:
            return False
        self._bench = bench = TuningBench(hands, features, Step(name), self.progressed.emit)
        run = threading.Thread(target=self._run, args=(name, tuning, bench), name="tuning", daemon=True)
        self._thread = run
        run.start()
        return True

    def cancel(self) -> None:
        """Give up what is under way; what it changed is restored first."""
        if (bench := self._bench) is not None:
            bench.cancelled.set()

    def wait(self, timeout: float) -> bool:
        """Whether it ended within `timeout` seconds."""
        if (thread := self._thread) is not None:
            thread.join(timeout)
            return not thread.is_alive()
        return True

    def _run(self, name: str, tuning: Tuning, bench: TuningBench) -> None:
        try:
            result = tuning(bench)
        except Exception as error:
            self.failed.emit(self._undone(name, bench, error))
        else:
            self.succeeded.emit(result)
        finally:
            bench.close()
            self._bench = None
            self.ended.emit()

    @staticmethod
    def _undone(name: str, bench: TuningBench, error: Exception) -> str:
        """Restore, and say why."""
        if not isinstance(error, GrabberError):
            log.exception("%s failed", name)
            error = GrabberError(f"internal error, see the log: {error}")
        cancelled = isinstance(error, TuningCancelledError)
        why = translate("Tuning", "cancelled") if cancelled else error_text(error)
        try:
            problems = bench.restore()
        except GrabberError as failure:
            problems = [str(failure)]
        if not problems:
            return f"{name}: {why}"
        text = translate("Tuning", "{0}: {1}; not all is as it was: {2}")
        return text.format(name, why, "; ".join(problems))


PATIENCE = 10.0
"Seconds a camera may take; it needs a few frames."
LOOK = 0.1
"Seconds between two looks at whether it is done."


def has_once(grabber: FrameGrabber, role: Role) -> bool:
    """Whether the camera can do it by itself."""
    return automatic_once(grabber, role) is not None


def let_camera(bench: TuningBench, role: Role) -> str:
    """Let the camera regulate once, and wait until it is done. What came of it.

    Raises TuningError where it does not end, FeatureError, TransportError.
    """
    auto = bench.call(lambda grabber: automatic_once(grabber, role))
    if auto is None:
        raise FeatureNotFoundError(f"{bench.title} does not regulate this once by itself", role.names[0])
    bench.call(lambda grabber: grabber.write_feature(auto, AUTO_ONCE))
    begun = time.monotonic()
    while regulating(bench.call(lambda grabber: grabber.feature(auto))):
        seconds = time.monotonic() - begun
        if seconds > PATIENCE:
            text = translate("Tuning", "{0} was not done within {1:g} s; does the camera send frames?")
            raise TuningError(text.format(auto, PATIENCE))
        bench.say(seconds / PATIENCE, translate("Tuning", "{0} at work").format(auto))
        bench.wait(LOOK)
    if role is not Role.EXPOSURE:
        return translate("Tuning", "White balance set by the camera")
    name = bench.call(lambda grabber: role.find(grabber.has_feature)) or role.names[0]
    exposure = bench.call(lambda grabber: grabber.feature(name))
    return translate("Tuning", "Exposure set by the camera: {0}").format(value_text(exposure))

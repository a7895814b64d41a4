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
from grabbergui.models.changes.tracking import ChangeTrackingGrabber
from grabbergui.models.error_text import error_text
from grabbergui.models.features.text import value_text
from grabbergui.models.features.tree import FeatureTreeModel
from grabbergui.models.language import translate
from grabbergui.models.tuning.parameters import automatic_once
from grabbergui.models.tuning.run import TuningCancelledError, TuningError, TuningRun

log = logging.getLogger(__name__)

Tuning = Callable[[TuningRun], str]
"Tunes a camera and returns its result as display text; raises GrabberError."


class OnePush:
    """Runs one tuning at a time. Methods return immediately; signals come from the tuning's thread."""

    progressed = Signal(float, str)
    """Progress (0 … 1), and the state as display text."""
    succeeded = Signal(str)
    """The result, as display text."""
    failed = Signal(str)
    """The reason of the failure; everything is restored, or the text names the exceptions."""
    ended = Signal()
    """The tuning ended, with or without success."""

    def __init__(self) -> None:
        self._current: TuningRun | None = None
        self._thread: threading.Thread | None = None

    @property
    def running(self) -> bool:
        """Whether a tuning is in progress."""
        return self._current is not None

    def start(
        self, name: str, tuning: Tuning, grabber: ChangeTrackingGrabber, features: FeatureTreeModel
    ) -> bool:
        """Start a tuning; `name` labels its undo step. Return False if one is in progress already."""
        if self._current is not None:
            return False
        self._current = run = TuningRun(grabber, features, Step(name), self.progressed.emit)
        thread = threading.Thread(target=self._run, args=(name, tuning, run), name="tuning", daemon=True)
        self._thread = thread
        thread.start()
        return True

    def cancel(self) -> None:
        """Cancel the tuning in progress; it restores its changes first."""
        if (run := self._current) is not None:
            run.cancelled.set()

    def wait(self, timeout: float) -> bool:
        """Wait up to `timeout` seconds; return whether the tuning has ended."""
        if (thread := self._thread) is not None:
            thread.join(timeout)
            return not thread.is_alive()
        return True

    def _run(self, name: str, tuning: Tuning, run: TuningRun) -> None:
        try:
            result = tuning(run)
        except Exception as error:
            self.failed.emit(self._restored(name, run, error))
        else:
            self.succeeded.emit(result)
        finally:
            run.close()
            self._current = None
            self.ended.emit()

    @staticmethod
    def _restored(name: str, run: TuningRun, error: Exception) -> str:
        """Restore the changes; return the reason of the failure as display text."""
        if not isinstance(error, GrabberError):
            log.exception("%s failed", name)
            error = GrabberError(f"internal error, see the log: {error}")
        cancelled = isinstance(error, TuningCancelledError)
        why = translate("Tuning", "cancelled") if cancelled else error_text(error)
        try:
            problems = run.restore()
        except GrabberError as failure:
            problems = [str(failure)]
        if not problems:
            return f"{name}: {why}"
        text = translate("Tuning", "{0}: {1}; not all is as it was: {2}")
        return text.format(name, why, "; ".join(problems))


PATIENCE = 10.0
"Seconds a camera may take; it needs a few frames."
LOOK = 0.1
"Seconds between two reads of the automatic mode."


def has_once(grabber: FrameGrabber, role: Role) -> bool:
    """Return whether the camera has an automatic mode for this that runs once."""
    return automatic_once(grabber, role) is not None


def let_camera(run: TuningRun, role: Role) -> str:
    """Let the camera regulate once, wait until it is done, and return the result as display text.

    Raises TuningError if it does not end, FeatureError, TransportError.
    """
    auto = run.call(lambda grabber: automatic_once(grabber, role))
    if auto is None:
        raise FeatureNotFoundError(f"{run.title} does not regulate this once by itself", role.names[0])
    run.call(lambda grabber: grabber.write_feature(auto, AUTO_ONCE))
    begun = time.monotonic()
    while regulating(run.call(lambda grabber: grabber.feature(auto))):
        seconds = time.monotonic() - begun
        if seconds > PATIENCE:
            text = translate("Tuning", "{0} was not done within {1:g} s; does the camera send frames?")
            raise TuningError(text.format(auto, PATIENCE))
        run.say(seconds / PATIENCE, translate("Tuning", "{0} at work").format(auto))
        run.wait(LOOK)
    if role is not Role.EXPOSURE:
        return translate("Tuning", "White balance set by the camera")
    name = run.call(lambda grabber: role.find(grabber.has_feature)) or role.names[0]
    exposure = run.call(lambda grabber: grabber.feature(name))
    return translate("Tuning", "Exposure set by the camera: {0}").format(value_text(exposure))

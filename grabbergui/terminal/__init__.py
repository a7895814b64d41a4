"""A camera by typed commands: text in, text out, no console in between.

The same commands serve the console, a YARP port and a ROS 2 service. Names of commands follow the reference
system's terminal (`list_features`, `get_feature`, `set_feature`).
"""

from __future__ import annotations

import inspect
import shlex
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from grabbergui.core.environment import expanded
from grabbergui.core.errors import FeatureNotFoundError, FrameTimeoutError, GrabberError, UsageError
from grabbergui.core.features import Feature, FeatureKind, Visibility
from grabbergui.core.frame import Frame
from grabbergui.core.frame_period import frame_wait
from grabbergui.core.frame_queue import FrameQueue
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.settings import SettingKey
from grabbergui.core.sfnc import AUTO_CONTINUOUS, AUTO_OFF, AUTO_ONCE
from grabbergui.core.visible_text import visible
from grabbergui.models.features.number_input import typed_value
from grabbergui.models.settings import feature_set, files
from grabbergui.models.settings.loading import load_onto
from grabbergui.recording import snapshot

_CANCEL_PERIOD = 0.2
"""Seconds between checks whether a command was cancelled while it waits for a frame."""
_WATCH_PERIOD = 0.05
_WATCH_LONGEST = 5.0
"""Seconds; a remote terminal waits seven for its answer."""
_MOST_FRAMES = 100
_REMOTE_LINE = 2000
"""Most characters of a remote line: splitting it into words takes 1 µs each."""
_ON_FILES = {"snapshot", "save", "load", "grab"}


@dataclass(frozen=True)
class TerminalCommand:
    """One command of the terminal."""

    arguments: str
    "The arguments as in the help: `NAME [VALUE]`."
    meaning: str
    run: Callable[..., list[str]]
    "Returns lines."


class Interpreter:
    """Runs one line at a time. Any thread, but one line at once.

    A `remote` one has no commands that read or write files: permission to set a gain over the network is no
    permission to write to this machine's disk.
    """

    def __init__(
        self,
        grabber: FrameGrabber,
        *,
        folder: Path | None = None,
        remote: bool = False,
        cancelled: Callable[[], bool] = lambda: False,
    ) -> None:
        """Setting `cancelled` ends commands that wait for the camera."""
        self._grabber = grabber
        self._cancelled = cancelled
        self._folder = folder or Path.cwd()
        self.finished = False
        "Set by `exit`."
        self.commands: dict[str, TerminalCommand] = {
            "list_features": TerminalCommand(
                "[TEXT]",
                "beginner and expert features with values; with TEXT: all whose name contains it",
                self._list_features,
            ),
            "get_feature": TerminalCommand("NAME", "a feature's value and range", self._get_feature),
            "set_feature": TerminalCommand(
                "NAME VALUE", "write a value; this switches off its automatic mode", self._set_feature
            ),
            "run": TerminalCommand("NAME", "execute a command of the camera", self._run),
            "auto": TerminalCommand(
                "NAME [Continuous|Once|Off]", "set a feature's automatic mode", self._auto
            ),
            "mode": TerminalCommand("NAME", "whether a feature is set by hand or by the camera", self._mode),
            "start": TerminalCommand("", "start the stream", self._start),
            "stop": TerminalCommand("", "stop the stream, for everybody", self._stop),
            "watch": TerminalCommand(
                "NAME [SECONDS]",
                "a feature's values for a while (2, at most 5 s)",
                self._watch,
            ),
            "grab": TerminalCommand("N [FOLDER]", "save the next N frames (at most 100)", self._grab),
            "snapshot": TerminalCommand(
                "[FOLDER]", "save the next frame, as PNG, or TIFF for more than 8 bits", self._snapshot
            ),
            "save": TerminalCommand("FILE", "save all settings: .yaml, or GenICam's own format", self._save),
            "load": TerminalCommand("FILE", "load settings and report the outcome of each", self._load),
            "stats": TerminalCommand(
                "", "frames, losses and rates since the stream was started", self._stats
            ),
            "help": TerminalCommand("", "this list", self._help),
            "exit": TerminalCommand("", "leave; ends a server", self._exit),
        }
        "The commands by name, for completion too."
        if remote:
            for name in _ON_FILES & self.commands.keys():
                del self.commands[name]
        self._aliases = {"list": "list_features", "get": "get_feature", "set": "set_feature", "quit": "exit"}

    def execute(self, line: str) -> str:
        """Run a line; return what to print, perhaps nothing, visible line by line.

        Raises GrabberError for what fails.
        """
        try:
            words = shlex.split(line)
        except ValueError as error:
            raise UsageError(f"'{line}': {error}") from error
        if not words:
            return ""
        name = self._aliases.get(words[0], words[0])
        command = self.commands.get(name)
        if command is None:
            raise UsageError(f"there is no command '{words[0]}'; `help` lists them")
        try:
            inspect.signature(command.run).bind(*words[1:])
        except TypeError:
            raise UsageError(f"write `{name} {command.arguments}`") from None
        return "\n".join(map(visible, command.run(*words[1:])))

    def _list_features(self, *text: str) -> list[str]:
        wanted = " ".join(text).lower()
        return [
            self._line(self._grabber.feature(description.name))
            for description in self._grabber.feature_tree().descriptions()
            if wanted in f"{description.name} {description.title}".lower()
            and (wanted or description.visibility <= Visibility.EXPERT)
        ] or [f"no feature's name contains '{wanted}'"]

    def _get_feature(self, name: str) -> list[str]:
        return [self._line(self._grabber.read_setting(SettingKey.parse(name)))]

    def _set_feature(self, name: str, *value: str) -> list[str]:
        # NAME=VALUE is the form of the command line.
        joined = SettingKey.parse_assignment(name) if not value else None
        key, text = joined or (SettingKey.parse(name), " ".join(value).removeprefix("=").strip())
        # An empty text is a value of its own, to be written as "".
        feature = self._grabber.feature(key.name)
        is_empty_text = "" in value and feature.kind is FeatureKind.STRING
        if not text and not is_empty_text:
            raise UsageError(f"{name}: which value? {self._grabber.read_setting(key).range_text()}")
        return [self._line(self._grabber.write_setting(key, typed_value(text, feature)).feature)]

    def _run(self, name: str) -> list[str]:
        self._grabber.execute_setting(SettingKey.parse(name))
        return [f"{name} is done"]

    def _auto(self, name: str, mode: str = AUTO_CONTINUOUS) -> list[str]:
        automatic = self._grabber.feature(name).auto
        if automatic is None:
            raise FeatureNotFoundError(f"{name} has no automatic mode on this camera", name)
        spelled = {text.lower(): text for text in (AUTO_CONTINUOUS, AUTO_ONCE, AUTO_OFF)}
        return [self._line(self._grabber.write_feature(automatic, spelled.get(mode.lower(), mode)))]

    def _mode(self, name: str) -> list[str]:
        automatic = self._grabber.feature(name).auto
        if automatic is None:
            return [f"{name} is set by hand; this camera has no automatic mode for it"]
        return [self._line(self._grabber.feature(automatic))]

    def _start(self) -> list[str]:
        self._grabber.start()
        return ["streaming"]

    def _stop(self) -> list[str]:
        self._grabber.stop()
        return ["stopped"]

    def _snapshot(self, folder: str = "") -> list[str]:
        queue = self._grabber.open_queue(1)
        try:
            frame = self._next_frame(queue)
        finally:
            queue.close()
        path = snapshot.save(frame, self._folder / expanded(folder), self._grabber.info)
        return [f"saved {path}"]

    def _grab(self, number: str, folder: str = "") -> list[str]:
        count = int(number) if number.isascii() and number.isdigit() else 0
        if not 1 <= count <= _MOST_FRAMES:
            raise UsageError(f"grab {number}: write a number of frames from 1 to {_MOST_FRAMES}")
        lines: list[str] = []
        while len(lines) < count and not self._cancelled():
            lines += self._snapshot(folder)
        return lines

    def _next_frame(self, queue: FrameQueue) -> Frame:
        """Wait in small steps, so that it can be cancelled. Raises FrameTimeoutError, UsageError."""
        if not (self._grabber.streaming or self._grabber.lost):
            raise UsageError("the camera is not streaming; type `start` first")
        timeout = frame_wait(self._grabber)
        deadline = time.monotonic() + timeout
        while True:
            try:
                return queue.get(_CANCEL_PERIOD)
            except FrameTimeoutError:
                if self._cancelled() or time.monotonic() > deadline:
                    raise FrameTimeoutError(f"no frame arrived within {round(timeout, 2):g} s") from None

    def _watch(self, name: str, seconds: str = "2") -> list[str]:
        try:
            span = float(seconds)
        except ValueError:
            span = 0.0
        if not 0 < span <= _WATCH_LONGEST:
            raise UsageError(f"watch {name} {seconds}: write seconds, up to {_WATCH_LONGEST:g}")
        start, lines, last = time.monotonic(), [], ""
        while (passed := time.monotonic() - start) < span and not self._cancelled():
            text = self._line(self._grabber.feature(name))
            if text != last:
                lines.append(f"{passed:5.2f} s  {text}")
                last = text
            time.sleep(_WATCH_PERIOD)
        return lines

    def _save(self, file: str) -> list[str]:
        path = self._folder / expanded(file)
        features = feature_set.capture(self._grabber)
        files.save(features, path)
        left_out = [f"left out {text}" for text in features.left_out]
        return [*left_out, f"saved {path} (settings: {len(features)})"]

    def _load(self, file: str) -> list[str]:
        path = self._folder / expanded(file)
        features = files.load(path, self._grabber.selectors.of)
        report = load_onto(self._grabber, features)
        if not (report.interrupted and report.written):
            return report.lines()
        again = "what was written is set again when the camera is back, the rest is not"
        return [*report.lines(), again]

    def _stats(self) -> list[str]:
        counters = self._grabber.statistics().as_dict()
        width = max(map(len, counters))
        return [f"{name.ljust(width)}  {value:.6g}" for name, value in counters.items()]

    def _help(self) -> list[str]:
        calls = {f"{name} {command.arguments}": command.meaning for name, command in self.commands.items()}
        width = max(map(len, calls))
        return [f"{call.ljust(width)}  {meaning}" for call, meaning in calls.items()]

    def _exit(self) -> list[str]:
        self.finished = True
        return []

    def _line(self, feature: Feature) -> str:
        feature = self._grabber.offered(feature)  # what only the stream locks can be set
        if feature.value is None:
            what = "a command" if feature.kind is FeatureKind.COMMAND else feature.access_problem()
            return f"{feature.name}: {what}"
        unit = f" {feature.unit}" if feature.unit else ""
        text = f"{feature.name} = {feature.text}{unit}"
        if not feature.access.writable:
            return f"{text} (read-only)"
        plain = feature.kind in (FeatureKind.STRING, FeatureKind.BOOLEAN)
        return text if plain else f"{text} ({feature.range_text()})"


def remote_terminal(grabber: FrameGrabber) -> Callable[[str], str]:
    """A grabber's terminal for remote users: several at once, each line by itself."""

    def run(line: str) -> str:
        if len(line) > _REMOTE_LINE:
            raise UsageError(f"a line of {len(line)} characters is too long, {_REMOTE_LINE} are allowed")
        return Interpreter(grabber, remote=True).execute(line)

    return run


def answer(interpreter: Interpreter, line: str) -> tuple[bool, str]:
    """Run a line; return whether it worked, and the text to print. Raises nothing that a user may cause."""
    try:
        return True, interpreter.execute(line)
    except GrabberError as error:
        return False, visible(str(error))

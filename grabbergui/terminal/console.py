"""The interactive prompt: completion of commands, features and entries, history, ranges while one types."""

from __future__ import annotations

import asyncio
import os
import select
import sys
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

from prompt_toolkit import PromptSession
from prompt_toolkit.completion import CompleteEvent, Completer, Completion
from prompt_toolkit.document import Document
from prompt_toolkit.patch_stdout import patch_stdout

from grabbergui.core.errors import GrabberError
from grabbergui.core.feature_source import FeatureSource
from grabbergui.core.features import FeatureKind
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.visible_text import print_lines, visible
from grabbergui.terminal import Interpreter, answer

_TAKES_FEATURE = frozenset(
    {"get_feature", "get", "set_feature", "set", "auto", "mode", "run", "watch", "list_features", "list"}
)
FINISHED_PERIOD = 0.1
"""Seconds between checks whether the end was asked for, while nothing is typed."""


class FeatureCompleter(Completer):
    """Completes commands first, then names of features, then entries."""

    def __init__(self, grabber: FrameGrabber, interpreter: Interpreter) -> None:
        self._grabber = grabber
        self._interpreter = interpreter
        self._features = list(grabber.feature_tree().descriptions())

    def get_completions(self, document: Document, complete_event: CompleteEvent) -> Iterable[Completion]:
        """Yield the completions; called by prompt_toolkit."""
        before = document.text_before_cursor
        words = before.split()
        typed = "" if not words or before.endswith(" ") else words[-1]
        position = len(words) - (1 if typed else 0)
        for text, meaning in self._candidates(words, position):
            if typed.lower() in text.lower() and text.isprintable():
                yield Completion(text, -len(typed), display_meta=visible(meaning))

    def _candidates(self, words: list[str], position: int) -> Iterator[tuple[str, str]]:
        if position == 0:
            for name, command in self._interpreter.commands.items():
                yield name, command.meaning
        elif position == 1 and words[0] in _TAKES_FEATURE:
            for description in self._features:
                if words[0] != "run" or description.kind is FeatureKind.COMMAND:
                    yield description.name, description.tooltip
        elif position == 2 and words[0] in ("set", "set_feature") and self._grabber.has_feature(words[1]):
            feature = self._grabber.feature(words[1])
            for entry in feature.entries:
                yield entry.name, entry.tooltip


@dataclass(frozen=True)
class ConsoleEnd:
    """How a console ended."""

    left: bool
    "Whether the user typed `exit`, or ended the input at a terminal; False if a script had no more lines."
    refused: int
    "Number of lines of a script that failed; 0 at a terminal, where the user saw the errors."


def run(grabber: FrameGrabber, *, finished: Callable[[], bool] = lambda: False) -> ConsoleEnd:
    """Read and run commands until `exit`, the end of the input, or `finished`, which ends long commands too.

    With a terminal it prompts and completes; without one it reads lines, for scripts.
    """
    interpreter = Interpreter(grabber, cancelled=finished)
    interactive = sys.stdin is not None and sys.stdin.isatty()
    lines = _prompted(grabber, interpreter, finished) if interactive else _piped(finished)
    refused = 0
    for line in lines:
        worked, text = answer(interpreter, line)
        refused += not (worked or interactive)
        if text:
            print_lines(text.split("\n"), error=not worked, flush=True)
        if interpreter.finished or finished():
            break
    return ConsoleEnd(left=interpreter.finished or interactive, refused=refused)


def _piped(finished: Callable[[], bool]) -> Iterator[str]:
    """Yield lines as they come; a silent script does not delay the end."""
    if sys.stdin is None:
        return
    descriptor = sys.stdin.fileno()
    rest = b""
    while not finished():
        if not select.select([descriptor], [], [], FINISHED_PERIOD)[0]:
            continue
        chunk = os.read(descriptor, 4096)
        *lines, rest = (rest + chunk).split(b"\n")
        for line in lines if chunk else [rest]:
            yield line.decode(errors="replace")
        if not chunk:
            return


def _prompted(grabber: FrameGrabber, interpreter: Interpreter, finished: Callable[[], bool]) -> Iterator[str]:
    console: PromptSession[str] = PromptSession(completer=FeatureCompleter(grabber, interpreter))

    async def leave_when_finished() -> None:
        while not finished():
            await asyncio.sleep(FINISHED_PERIOD)
        if not console.app.is_done:
            console.app.exit(exception=EOFError)

    def watch_for_the_end() -> None:
        console.app.create_background_task(leave_when_finished())

    while True:
        try:
            # Output of other threads goes above the prompt.
            with patch_stdout():
                yield console.prompt(
                    "camera> ",
                    bottom_toolbar=lambda: _hint(grabber, console),
                    pre_run=watch_for_the_end,
                )
        except (EOFError, KeyboardInterrupt):
            return


def _hint(grabber: FeatureSource, console: PromptSession[str]) -> str:
    """Return the allowed values of the feature that is being typed."""
    words = console.default_buffer.text.split()
    if len(words) < 2 or not grabber.has_feature(words[1]):
        return "Tab completes; help lists the commands"
    try:
        feature = grabber.feature(words[1])
    except GrabberError as error:
        return visible(str(error))
    return visible(f"{feature.name}: {feature.range_text()}")

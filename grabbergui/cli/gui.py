"""Interactive commands: the window, and a terminal."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from grabbergui import sources
from grabbergui.cli.arguments import add_source, opened, wait_time
from grabbergui.cli.process import stop_on_signals
from grabbergui.core.errors import MissingFileError, SourceUnavailableError
from grabbergui.core.missing_packages import explained
from grabbergui.core.uri import SourceUri

EXIT_REFUSED = 1
"Exit code when a line of a script was refused."


def add_commands(commands: Any) -> None:
    """Add the parsers of this family."""
    _add_gui(commands)
    _add_terminal(commands)


def _add_gui(commands: Any) -> None:
    parser = commands.add_parser(
        "gui",
        help="open the window (the default command)",
        example="grabbergui gui gige:GV01",
    )
    parser.add_argument(
        "source",
        metavar="SOURCE",
        nargs="?",
        help="the source to open (the last one, or sim:colour at the first start). "
        "With a settings file, such as file:camera.yaml, compare the last camera with it",
    )
    parser.add_argument("--offscreen", action="store_true", help="run the window without a display")
    parser.add_argument("--duration", type=wait_time, metavar="S", help="close the window after S seconds")
    parser.add_argument("--screenshot", type=Path, metavar="FILE", help="save a screenshot of the window")
    parser.add_argument(
        "--script",
        type=Path,
        metavar="FILE",
        help="run a Python script with the window and exit with its code",
    )
    add_theme(parser)
    parser.add_argument("--language", metavar="CODE", help="language of the window: en, es (the desktop's)")
    parser.set_defaults(run=_gui)


def _gui(options: argparse.Namespace) -> int:
    source, settings = options.source, None
    if source is not None and (settings := _settings_file(sources.parse(source))) is not None:
        source = None
    with importing_window("which cannot be loaded"):
        from grabbergui.ui.run import window
    with stop_on_signals() as stop:
        return window.run(
            source,
            settings=settings,
            offscreen=options.offscreen,
            duration=options.duration,
            screenshot=options.screenshot,
            script=options.script,
            theme=options.theme,
            language=options.language,
            stop=stop,
        )


def add_theme(parser: argparse.ArgumentParser) -> None:
    """Add `--theme`, for every command with a window."""
    parser.add_argument(
        "--theme",
        choices=("auto", "light", "dark"),
        default="auto",
        help="colours of the window (the desktop's)",
    )


@contextmanager
def importing_window(otherwise: str) -> Iterator[None]:
    """Raise SourceUnavailableError if the block cannot import Qt; `otherwise` is the advice without it."""
    try:
        yield
    except ImportError as error:
        raise SourceUnavailableError(f"the window needs PyQt5, {otherwise}: {explained(error)}") from error


def _settings_file(uri: SourceUri) -> Path | None:
    """Return the path of a file of settings, as a desktop names it when one is double-clicked."""
    from grabbergui.models.settings.files import SETTINGS_SUFFIXES

    path = Path(uri.name)
    if uri.scheme != sources.SourceKind.FILE.value or path.suffix.lower() not in SETTINGS_SUFFIXES:
        return None
    if not path.is_file():
        raise MissingFileError(f"{path} does not exist; name a file of settings, or a source such as sim:")
    return path


def _add_terminal(commands: Any) -> None:
    parser = commands.add_parser(
        "terminal",
        help="type commands to a camera; the command `help` lists them",
        example="grabbergui terminal gige:",
    )
    add_source(parser)
    parser.set_defaults(run=_terminal)


def _terminal(options: argparse.Namespace) -> int:
    from grabbergui.terminal import console

    with stop_on_signals() as stop, opened(options.source, reading=True) as grabber:
        outcome = console.run(grabber, finished=stop.is_set)
    return EXIT_REFUSED if outcome.refused else 0

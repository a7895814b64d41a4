"""The findings of the checks, each with its remedy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum


class Level(Enum):
    """Severity of a finding."""

    GOOD = "ok"
    NOTE = "note"
    "Something optional is missing."
    PROBLEM = "problem"


@dataclass(frozen=True)
class Finding:
    """One line of the report, and its remedy."""

    level: Level
    text: str
    remedy: str = ""
    "A command or a sentence; empty if nothing need be done."
    mend: Callable[[], object] | None = field(default=None, compare=False)
    "Does what the remedy says, and waits for it; raises GrabberError. None if only a person can."


def good(text: str) -> Finding:
    """Return a finding without anything to do."""
    return Finding(Level.GOOD, text)


def note(text: str, remedy: str = "", mend: Callable[[], object] | None = None) -> Finding:
    """Return a finding about something optional."""
    return Finding(Level.NOTE, text, remedy, mend)


def problem(text: str, remedy: str) -> Finding:
    """Return a finding about a problem."""
    return Finding(Level.PROBLEM, text, remedy)

"""The findings of the checks, each with its remedy."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    pass


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


def good(text: str) -> Finding:
    """Return a finding without anything to do."""
    return Finding(Level.GOOD, text)


def note(text: str, remedy: str = "") -> Finding:
    """Return a finding about something optional."""
    return Finding(Level.NOTE, text, remedy)


def problem(text: str, remedy: str) -> Finding:
    """Return a finding about a problem."""
    return Finding(Level.PROBLEM, text, remedy)

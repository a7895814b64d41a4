"""Checks for the usual problems between a camera and the window: what each found, and the remedy."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Level(Enum):
    """How bad it is."""

    GOOD = "ok"
    NOTE = "note"
    "Something optional is missing."
    PROBLEM = "problem"


@dataclass(frozen=True)
class Finding:
    """One line of the report, and what to do about it."""

    level: Level
    text: str
    remedy: str = ""
    "A command or a sentence; empty where nothing need be done."


def good(text: str) -> Finding:
    """Nothing to do."""
    return Finding(Level.GOOD, text)


def note(text: str, remedy: str = "") -> Finding:
    """Something that matters only to those who use it."""
    return Finding(Level.NOTE, text, remedy)


def problem(text: str, remedy: str) -> Finding:
    """Something to mend."""
    return Finding(Level.PROBLEM, text, remedy)

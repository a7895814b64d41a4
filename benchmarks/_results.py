"""Results of a benchmark: tables, charts and goals as plain data."""

from __future__ import annotations

import os
import platform
from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True)
class Table:
    """A header and rows of formatted text."""

    header: list[str]
    rows: list[list[str]]
    title: str = ""


@dataclass(frozen=True)
class Chart:
    """Grouped bars: one colour for each series, one group for each category."""

    name: str
    "Name of its file; unique."
    title: str
    unit: str
    groups: list[str]
    series: dict[str, list[float | None]]
    "One value for each group; None for a missing one."
    goal: float | None = None
    "Value of the goal, drawn as a line."
    goal_text: str = ""
    logarithmic: bool = False


@dataclass(frozen=True)
class Goal:
    """A goal and the result; `met` is computed from the measured values."""

    asked: str
    measured: str
    met: bool


@dataclass(frozen=True)
class Section:
    """One chapter of docs/benchmarks.md."""

    title: str
    program: str
    "The command that repeats the measurement."
    method: str
    "Description of the method: paragraphs of Markdown."
    tables: list[Table]
    charts: list[Chart] = field(default_factory=list)
    goals: list[Goal] = field(default_factory=list)
    reading: list[str] = field(default_factory=list)
    "Explanations of the columns, one list item each."
    machine: str = ""
    lacking: str = ""
    "The program that was missing for the comparison; such a section never replaces a complete one."


def machine() -> str:
    """Describe the machine in one line, with its current load and the priority of the measured programs."""
    known = Path("/proc/cpuinfo")
    lines = known.read_text().splitlines() if known.exists() else []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    model = models[0] if models else platform.processor()
    load = os.getloadavg()[0]
    busy = "; the machine was busy" if load > 0.6 * (os.cpu_count() or 1) else ""
    # os.nice(0) changes nothing; Windows has no such number.
    niceness = os.nice(0) if hasattr(os, "nice") else 0
    priority = f"; measured at nice {niceness}" if niceness else ""
    return (
        f"{os.cpu_count()} cores ({model}), {platform.system()} {platform.release().split('-')[0]}, "
        f"Python {platform.python_version()}, load average {load:.1f} before{busy}{priority}"
    )

"""Fault injection, and docs/reliability.md with the results.

A fault is a function that disturbs running programs and returns a measured `Outcome`; the decorator `fault`
registers it. `reliability.MODULES` lists the modules that have faults.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

from benchmarks._document import table
from benchmarks._results import Table

DOCUMENT = Path(__file__).parents[1] / "docs/reliability.md"
RESULTS = Path(__file__).parent / "results/reliability"
PREAMBLE = """# Reliability

These faults were injected into running programs. The tables show what was lost, and how long the recovery
took, in one run on one machine. `python -m benchmarks reliability` injects every fault again and rewrites
this page; `python -m benchmarks reliability NAME …` injects single ones.
"""


@dataclass(frozen=True)
class Outcome:
    """The measured effect of a fault, as texts for the page."""

    done: str
    "The fault and the program that it was injected into."
    times: str
    "How often or how long."
    lost: str
    well_after: str
    "How long the recovery took."
    survived: bool = True
    "Whether the program met its promise; the page marks rows where it did not."
    machine: str = ""


Fault = Callable[[], Outcome]
FAULTS: dict[str, tuple[str, Fault]] = {}
"""By name: the table of the page, and the function."""


def fault(chapter: str) -> Callable[[Fault], Fault]:
    """Register a function as a fault, under its own name."""

    def add(function: Fault) -> Fault:
        FAULTS[function.__name__.replace("_", "-")] = (chapter, function)
        return function

    return add


def keep(name: str, outcome: Outcome, folder: Path = RESULTS) -> None:
    """Store an outcome in a file of its own, so that each fault can be injected alone."""
    folder.mkdir(parents=True, exist_ok=True)
    text = json.dumps(asdict(outcome), indent=1, ensure_ascii=False)
    (folder / f"{name}.json").write_text(text + "\n", encoding="utf-8")


def kept(folder: Path = RESULTS) -> dict[str, Outcome]:
    """Return all stored outcomes, by the fault's name."""
    return {
        path.stem: Outcome(**json.loads(path.read_text(encoding="utf-8")))
        for path in sorted(folder.glob("*.json"))
    }


def document(outcomes: dict[str, Outcome]) -> str:
    """Return the page. The same outcomes give the same page; a fault without an outcome has no row."""
    parts = [PREAMBLE]
    failed = [name for name in FAULTS if name in outcomes and not outcomes[name].survived]
    if failed:
        parts.append(f"**Not survived: {', '.join(failed)}.**\n")
    for chapter in dict.fromkeys(chapter for chapter, _ in FAULTS.values()):
        names = [name for name, (where, _) in FAULTS.items() if where == chapter and name in outcomes]
        rows = [
            [
                outcomes[name].done,
                outcomes[name].times,
                outcomes[name].lost,
                outcomes[name].well_after + ("" if outcomes[name].survived else " **(failed)**"),
            ]
            for name in names
        ]
        if rows:
            header = ["fault", "how often", "lost", "recovered after"]
            where = _machines([outcomes[name].machine for name in names])
            parts.append(f"## {chapter}\n\n{table(Table(header, rows))}\n\nMeasured on {where}.\n")
    return "\n".join(parts)


def _machines(texts: list[str]) -> str:
    """Return each machine once, with the range of load averages before its measurements."""
    loads: dict[str, list[float]] = {}
    for text in texts:
        found = re.fullmatch(r"(.*), load average ([\d.]+) before.*", text)
        loads.setdefault(found[1] if found else text, []).extend([float(found[2])] if found else [])
    return "; ".join(
        f"{name}, load average {min(values):g} to {max(values):g} before" if values else name
        for name, values in loads.items()
    )

"""Faults that are tried on purpose, and docs/reliability.md, which says what each of them cost.

A fault is a function that does something bad to running programs and returns a measured `Outcome`; the
decorator `fault` puts it on the list. Modules of faults are named in `reliability.MODULES`.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

from benchmarks._document import table
from benchmarks._results import KEPT, Table

DOCUMENT = Path(__file__).parents[1] / "docs/reliability.md"
RESULTS = KEPT / "reliability"
PREAMBLE = """# Reliability

What was done to running programs on purpose, how often, what was lost, and how long it took until all was
well. `python -m benchmarks reliability` tries every fault again and rewrites this page; `python -m benchmarks
reliability NAME …` tries some of them. Times are of one run on one machine.
"""


@dataclass(frozen=True)
class Outcome:
    """The cost of a fault. Texts are ready to be read, the numbers in them measured."""

    done: str
    "What was done, to what."
    times: str
    "How often or how long."
    lost: str
    well_after: str
    "How long until all was well."
    survived: bool = True
    "Whether the promise held; a row of which it did not is marked."
    machine: str = ""


Fault = Callable[[], Outcome]
FAULTS: dict[str, tuple[str, Fault]] = {}
"""By name: the table that it stands in, and the function."""


def fault(chapter: str) -> Callable[[Fault], Fault]:
    """Put a function on the list; its name is the fault's."""

    def add(function: Fault) -> Fault:
        FAULTS[function.__name__.replace("_", "-")] = (chapter, function)
        return function

    return add


def keep(name: str, outcome: Outcome, folder: Path = RESULTS) -> None:
    """Write an outcome beside the others, so that one fault can be tried without the rest."""
    folder.mkdir(parents=True, exist_ok=True)
    text = json.dumps(asdict(outcome), indent=1, ensure_ascii=False)
    (folder / f"{name}.json").write_text(text + "\n", encoding="utf-8")


def kept(folder: Path = RESULTS) -> dict[str, Outcome]:
    """All outcomes there are, by the fault's name."""
    return {
        path.stem: Outcome(**json.loads(path.read_text(encoding="utf-8")))
        for path in sorted(folder.glob("*.json"))
    }


def document(outcomes: dict[str, Outcome]) -> str:
    """The whole page. The same outcomes give the same page; a fault that was never tried has no row."""
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
            header = ["what was done", "how often", "what was lost", "all was well after"]
            where = _machines([outcomes[name].machine for name in names])
            parts.append(f"## {chapter}\n\n{table(Table(header, rows))}\n\nMeasured on {where}.\n")
    return "\n".join(parts)


def _machines(texts: list[str]) -> str:
    """Each machine once, with the load averages that its measurements began with."""
    loads: dict[str, list[float]] = {}
    for text in texts:
        found = re.fullmatch(r"(.*), load average ([\d.]+) before.*", text)
        loads.setdefault(found[1] if found else text, []).extend([float(found[2])] if found else [])
    return "; ".join(
        f"{name}, load average {min(values):g} to {max(values):g} before" if values else name
        for name, values in loads.items()
    )

"""Writes sections of docs/benchmarks.md and their charts. The same results give the same section."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from importlib.util import find_spec
from pathlib import Path

from benchmarks._results import Chart, Section, Table

DOCUMENT = Path(__file__).parents[1] / "docs/benchmarks.md"
IMAGES = "images/benchmarks"
"Folder of the charts, relative to the document."
PREAMBLE = """# Benchmarks

The figures of a table come from one run on one machine: compare its rows with each other, not with those of
other tables. `make bench` measures everything again and rewrites this page; `python -m benchmarks NAME` does
so for one section.
"""
ORDER = (
    "Tuning",
    "GigE Vision",
    "GigE Vision, losses and latency",
    "USB3 Vision",
    "Both networks at once",
    "The DDS profile",
    "Compared with camera_aravis2",
    "Compared with a C publisher",
    "YARP ports",
    "Painting",
    "Recording",
    "Converting images",
    "The simulated sensor",
)
"""Sections in the order in which they are read; others follow."""
GOAL = re.compile(r"^\| (.+?) \| (.+?) \| (yes|\*\*no\*\*) \|$", re.MULTILINE)
"""A row of a section's table of goals: what is asked, what was measured, whether that meets it."""
_COLOURS = ("#3d7ea6", "#e08e45", "#6aa84f", "#a64d79", "#8c8c8c", "#c2b280", "#46627f")


def put(section: Section, document: Path = DOCUMENT) -> bool:
    """Put a section into the document, in place of its former one; draw its charts.

    Return False, and leave all as it is, if it lacks a comparison that the former one has.
    """
    chapters = _chapters(document.read_text(encoding="utf-8") if document.exists() else "")
    former = chapters.get(section.title)
    if former and section.lacking and f"without {section.lacking}." not in former:
        return False
    chapters[section.title] = markdown(section)
    if find_spec("matplotlib") is None:
        print("The charts stay as they are: matplotlib is not installed (make setup).")
    else:
        for chart in section.charts:
            draw(chart, document.parent / IMAGES / f"{chart.name}.svg")
    titles = [title for title in ORDER if title in chapters]
    titles += [title for title in chapters if title not in ORDER]
    bodies = [chapters[title].strip() + "\n" for title in titles]
    summary = _summary([(title, row) for title in titles for row in GOAL.findall(chapters[title])])
    document.write_text("\n".join([PREAMBLE, *summary, *bodies]), encoding="utf-8")
    return True


def _summary(goals: list[tuple[str, tuple[str, str, str]]]) -> list[str]:
    """Return how many goals are met, and a list of those that are not."""
    if not goals:
        return []
    missed = [f"- {title}: {asked}: {measured}" for title, (asked, measured, met) in goals if met != "yes"]
    line = f"Of the {len(goals)} goals in the tables below, {len(goals) - len(missed)} are met."
    return ["\n".join([f"{line} Not met:", "", *missed] if missed else [line]) + "\n"]


def _chapters(text: str) -> dict[str, str]:
    """Return the document's sections by title, in order."""
    parts = re.split(r"^(?=## )", text, flags=re.MULTILINE)[1:]
    return {part.splitlines()[0].removeprefix("## ").strip(): part for part in parts}


def markdown(section: Section) -> str:
    """Return a section as Markdown, with links to the charts."""
    parts = [f"## {section.title}", f"```sh\n{section.program}\n```", section.method.strip()]
    if section.goals:
        rows = [[goal.asked, goal.measured, "yes" if goal.met else "**no**"] for goal in section.goals]
        parts.append(table(Table(["goal", "measured", "met"], rows)))
    parts += [f"![{chart.title}]({IMAGES}/{chart.name}.svg)" for chart in section.charts]
    for each in section.tables:
        parts += [each.title, table(each)] if each.title else [table(each)]
    if section.reading:
        parts.append("\n".join(f"- {point}" for point in section.reading))
    if section.machine:
        lacking = f", without {section.lacking}" if section.lacking else ""
        parts.append(f"Measured on {section.machine}{lacking}.")
    return "\n\n".join(parts) + "\n"


def table(content: Table) -> str:
    lines = [content.header, ["---"] * len(content.header), *content.rows]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in lines)


def draw(chart: Chart, path: Path) -> None:
    """Draw horizontal bars as SVG. Nothing but the values changes from run to run."""
    import matplotlib

    matplotlib.use("svg")
    from matplotlib import pyplot

    matplotlib.rcParams["svg.hashsalt"] = chart.name
    matplotlib.rcParams |= {"svg.fonttype": "none", "font.size": 9}
    count = len(chart.series)
    thickness = 0.8 / count
    height = 0.9 + len(chart.groups) * max(0.22 * count, 0.36)
    start = _first_decade(chart) if chart.logarithmic else 0.0
    figure, axes = pyplot.subplots(figsize=(8, height), layout="constrained")
    for index, (name, values) in enumerate(chart.series.items()):
        places = [group + (index - (count - 1) / 2) * thickness for group in range(len(chart.groups))]
        lengths = [max((value or 0.0) - start, 0.0) for value in values]
        colour = _COLOURS[index % len(_COLOURS)]
        bars = axes.barh(places, lengths, thickness * 0.92, left=start, label=name, color=colour)
        axes.bar_label(bars, [_number(value) for value in values], padding=3, fontsize=8)
    if chart.goal is not None:
        axes.axvline(chart.goal, color="#b00020", linestyle="--", linewidth=1, label=chart.goal_text)
    if chart.logarithmic:
        axes.set_xscale("log")
        axes.xaxis.set_major_formatter("{x:g}")
    axes.set_yticks(range(len(chart.groups)), chart.groups)
    axes.invert_yaxis()
    axes.margins(x=0.1)
    axes.set_xlim(left=start)
    axes.set_title(chart.title, fontsize=10, loc="left")
    axes.set_xlabel(chart.unit)
    axes.spines[["top", "right"]].set_visible(False)
    if count > 1 or chart.goal is not None:
        figure.legend(loc="outside lower center", ncols=min(count + 1, 4), frameon=False, fontsize=8)
    path.parent.mkdir(parents=True, exist_ok=True)
    none = dict.fromkeys(("Creator", "Date", "Format", "Type"))
    figure.savefig(path, format="svg", facecolor="white", metadata=none)
    pyplot.close(figure)


def _first_decade(chart: Chart) -> float:
    """Return the start of logarithmic bars, which have no zero."""
    values = [value for series in chart.series.values() for value in series if value]
    return float(10 ** math.floor(math.log10(min(values)))) if values else 1.0


def _number(value: float | None) -> str:
    if value is None:
        return ""
    return f"{value:.0f}" if abs(value) >= 100 else f"{value:.3g}"


def printed(sections: Iterable[Section]) -> str:
    """Return the text that a benchmark prints."""
    return "\n".join(markdown(section) for section in sections)

"""The page of benchmarks is written section by section, and keeps the others."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip("benchmarks", reason="benchmarks/ is found from the checkout: python -m pytest")

from benchmarks import _document
from benchmarks._results import Chart, Goal, Section, Table

SECTION = Section(
    "Speed",
    "python -m benchmarks speed",
    "How it was measured.",
    [Table(["what", "fps"], [["ours", "12.5"], ["theirs", "10.0"]])],
    [Chart("speed", "Speed", "frames/s", ["1080p", "8.8 MP"], {"ours": [12.5, None], "theirs": [10.0, 2.0]})],
    [Goal("as fast as theirs", "1.25 ×", True), Goal("no loss", "3 lost", False)],
    ["**fps**: whole frames."],
    "2 cores",
)


def test_a_section_without_its_peer_does_not_replace_a_complete_one(tmp_path):
    pytest.importorskip("matplotlib")
    document = tmp_path / "benchmarks.md"
    lacking = replace(SECTION, lacking="the peer")

    assert _document.put(lacking, document)
    assert "Measured on 2 cores, without the peer.\n" in document.read_text()
    assert _document.put(lacking, document)
    assert _document.put(SECTION, document)
    assert not _document.put(lacking, document)
    assert "Measured on 2 cores.\n" in document.read_text()


def test_markdown_shows_rows_goals_and_charts():
    text = _document.markdown(SECTION)

    assert text.startswith("## Speed\n")
    assert "| ours | 12.5 |" in text
    assert "| as fast as theirs | 1.25 × | yes |" in text and "| no loss | 3 lost | **no** |" in text
    assert "![Speed](images/benchmarks/speed.svg)" in text


def test_only_the_measured_section_is_replaced(tmp_path):
    pytest.importorskip("matplotlib")
    document = tmp_path / "benchmarks.md"
    other = "| goal | measured | met |\n| --- | --- | --- |\n| no wait | 2 ms | **no** |\n"
    document.write_text(f"# Old\n\n## By hand\n\n{other}\n## Speed\n\nold figures\n\n## Last\n\nmore\n")

    _document.put(SECTION, document)

    text = document.read_text()
    assert text.startswith("# Benchmarks\n") and "old figures" not in text
    titles = [line for line in text.splitlines() if line.startswith("## ")]
    assert titles == ["## By hand", "## Speed", "## Last"]
    missed = "- By hand: no wait: 2 ms\n- Speed: no loss: 3 lost\n"
    assert f"Of the 3 goals in the tables below, 1 are met. Not met:\n\n{missed}\n" in text
    assert other in text and text.endswith("more\n")
    assert (tmp_path / "images/benchmarks/speed.svg").exists()


def test_the_same_results_give_the_same_bytes(tmp_path):
    pytest.importorskip("matplotlib")
    for name in ("one.svg", "two.svg"):
        _document.draw(SECTION.charts[0], tmp_path / name)

    assert (tmp_path / "one.svg").read_bytes() == (tmp_path / "two.svg").read_bytes()


def test_bars_are_as_long_as_their_values(tmp_path, monkeypatch):
    pyplot = pytest.importorskip("matplotlib.pyplot")
    drawn = []
    monkeypatch.setattr(pyplot, "close", drawn.append)

    _document.draw(replace(SECTION.charts[0], goal=11.0, goal_text="asked for"), tmp_path / "chart.svg")

    (axes,) = drawn[0].axes
    assert sorted(bar.get_width() for bar in axes.patches) == [0.0, 2.0, 10.0, 12.5]
    assert [line.get_xdata()[0] for line in axes.lines] == [11.0]
    assert "asked for" in (tmp_path / "chart.svg").read_text()


DOCS = Path(__file__).parents[2] / "docs"
LINK = re.compile(r"benchmarks\.md#([a-z0-9-]+)")
FIGURE = re.compile(r"(?<![\d.])(\d+(?:\.\d+)?) ?(?:ms|mm|MB/s|fps|frames/s|°|%|×(?!\d))")


def measured_sections():
    """Return the numbers of each section of benchmarks.md, by the anchor of its title."""
    text = (DOCS / "benchmarks.md").read_text(encoding="utf-8")
    sections = (part.partition("\n") for part in re.split(r"^## ", text, flags=re.MULTILINE)[1:])
    return {
        re.sub(r"[^a-z0-9 -]", "", title.lower()).replace(" ", "-"): set(re.findall(r"\d+(?:\.\d+)?", body))
        for title, _, body in sections
    }


def test_figures_in_the_manual_match_the_linked_sections():
    sections, wrong, compared = measured_sections(), [], 0
    for page in sorted(DOCS.glob("*.md")):
        if page.name == "benchmarks.md":
            continue
        for paragraph in re.split(r"\n\s*\n", page.read_text(encoding="utf-8")):
            if not (anchors := LINK.findall(paragraph)):
                continue
            wrong += [f"{page.name} links to #{anchor}" for anchor in anchors if anchor not in sections]
            known = set().union(*(sections.get(anchor, set()) for anchor in anchors))
            figures = FIGURE.findall(paragraph)
            wrong += [f"{page.name}: {figure}, see {anchors}" for figure in figures if figure not in known]
            compared += len(figures)
    assert not wrong
    assert compared >= 5

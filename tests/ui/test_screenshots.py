"""The manual's pictures are what the program makes: each panel, in both looks.

They are kept in the folder that GRABBERGUI_ARTEFACTS names, if it does.
"""

import os
import re
from pathlib import Path

import pytest
from PyQt5.QtGui import QImage

from grabbergui.ui.scripting import load_script, run_script
from grabbergui.ui.theme import DARK, LIGHT, Theme, dress

ROOT = Path(__file__).parents[2]
MANUAL = sorted((ROOT / "docs").glob("*.md"))


@pytest.fixture
def dressed(qapp):
    before = qapp.palette(), qapp.styleSheet(), qapp.style().objectName(), qapp.font()
    yield lambda theme: dress(qapp, theme)
    qapp.setStyle(before[2])
    qapp.setStyleSheet(before[1])
    qapp.setPalette(before[0])
    qapp.setFont(before[3])


@pytest.mark.parametrize(
    ("theme", "suffix", "ground"),
    [(Theme.LIGHT, "", LIGHT.window), (Theme.DARK, "-dark", DARK.window)],
    ids=["light", "dark"],
)
def test_every_panel_has_its_picture(request, dressed, tmp_path, monkeypatch, theme, suffix, ground):
    folder = Path(os.environ.get("GRABBERGUI_ARTEFACTS", tmp_path)) / "screenshots"
    monkeypatch.setenv("SCREENSHOTS", str(folder))
    dressed(theme)
    desk = request.getfixturevalue("window_desk")
    assert run_script(load_script(ROOT / "scripts" / "screenshots.py"), desk.program) == 0
    pictures = {path.stem.removesuffix("-dark"): QImage(str(path)) for path in folder.glob(f"*{suffix}.png")}
    assert {"window", "histogram", "focus", "profile", "changes", "gallery", "playback"} <= pictures.keys()
    for name, picture in pictures.items():
        colours = {picture.pixel(x, y) for x in range(0, picture.width(), 3) for y in range(picture.height())}
        assert len(colours) > 20, f"{name} shows nothing"
        edges = [picture.pixelColor(x, y) for x in range(picture.width()) for y in (2, picture.height() - 3)]
        assert any(colour.name() == ground for colour in edges), name


@pytest.mark.parametrize("page", MANUAL, ids=lambda page: page.stem)
def test_the_manuals_pictures_are_there(page):
    used = re.findall(r'(?:\]\(|src=")(images/[^)"]+\.png)', page.read_text())
    used += re.findall(r'srcset="(images/[^"]+\.png)"', page.read_text())
    assert not [name for name in used if not (page.parent / name).is_file()]

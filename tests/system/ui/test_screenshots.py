"""The manual's images are what the program makes: each panel, in both looks.

They are kept in the folder that GRABBERGUI_ARTEFACTS names, if it does.
"""

import os
import re
from pathlib import Path

import numpy as np
import pytest
from PyQt5.QtGui import QColor, QImage

from every_case import every_case
from grabbergui.ui.run.scripting import ScriptApi, load_script, run_script
from grabbergui.ui.theme import DARK, LIGHT, Theme, dress
from patience import PATIENCE

ROOT = Path(__file__).parents[3]
MANUAL = sorted((ROOT / "docs").glob("*.md"))
LONGEST_WAIT = 0.05
"""Seconds. The script waits longer for curves that are worth a look, if somebody takes one."""


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
def test_every_panel_has_its_image(request, dressed, tmp_path, monkeypatch, theme, suffix, ground):
    folder = Path(os.environ.get("GRABBERGUI_ARTEFACTS", tmp_path)) / "screenshots"
    monkeypatch.setenv("SCREENSHOTS", str(folder))
    monkeypatch.setattr("grabbergui.ui.run.scripting.PATIENCE", PATIENCE)
    if "GRABBERGUI_ARTEFACTS" not in os.environ:
        wait = ScriptApi.wait
        monkeypatch.setattr(ScriptApi, "wait", lambda app, seconds: wait(app, min(seconds, LONGEST_WAIT)))
    dressed(theme)
    app = request.getfixturevalue("app")
    assert run_script(load_script(ROOT / "scripts" / "screenshots.py"), app.program) == 0
    images = {path.stem.removesuffix("-dark"): QImage(str(path)) for path in folder.glob(f"*{suffix}.png")}
    assert {"window", "histogram", "focus", "profile", "changes", "gallery", "playback"} <= images.keys()
    for name, image in images.items():
        colours = pixels(image)
        assert np.unique(colours[:, ::3]).size > 20, f"{name} shows nothing"
        assert QColor(ground).rgb() & 0xFFFFFF in colours[[2, -3]], name


def pixels(image: QImage) -> np.ndarray:
    """Rows of 0xRRGGBB."""
    image = image.convertToFormat(QImage.Format_RGB32)
    words = np.frombuffer(image.constBits().asarray(image.sizeInBytes()), np.uint32)
    return words.reshape(image.height(), -1)[:, : image.width()] & 0xFFFFFF


@every_case("page", MANUAL, ids=lambda page: page.stem)
def test_the_manuals_images_are_there(page):
    used = re.findall(r'(?:\]\(|src=")(images/[^)"]+\.png)', page.read_text())
    used += re.findall(r'srcset="(images/[^"]+\.png)"', page.read_text())
    assert not [name for name in used if not (page.parent / name).is_file()]

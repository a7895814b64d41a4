"""The window in Spanish: nothing that can be seen stays in English, and nothing in the sources is missing."""

import ast
import re
import string
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest
from PyQt5.QtCore import QCoreApplication, QLocale
from PyQt5.QtWidgets import (
    QAbstractButton,
    QAction,
    QComboBox,
    QDockWidget,
    QLabel,
    QLineEdit,
    QMenu,
    QTabBar,
    QWidget,
)

from grabbergui.core.errors import UsageError
from grabbergui.models import language as models_language
from grabbergui.ui.editors.feature_row import FeatureRow
from grabbergui.ui.interface_language import languages, speak
from grabbergui.ui.views.feature_panel import Section
from grabbergui.ui.views.help_views import ShortcutsDialog
from grabbergui.ui.widgets.plots import ChannelPlot

ROOT = Path(__file__).parents[3]
TRANSLATIONS = ROOT / "resources" / "translations"
TRANSLATED = [*(ROOT / "grabbergui").rglob("ui"), *(ROOT / "grabbergui").rglob("models")]
NO_PLURAL = "is|es|was|does|has|más|controls|sets|pass|fps"
SEVERAL = re.compile(rf"(\{{\d[^}}]*\}}|\b1)\s+(?!(?:{NO_PLURAL})\b)[^\W\d]\w+s\b")
"A number and a plural."
NO_COUNT = {
    " (GevSCPSPacketSize, now {0} bytes)",  # at least 576
    " Packets of {0} bytes need an MTU as large on every device between.",
    "of {0} × {1} pixels at ({2}, {3})",  # regions of less cannot be drawn
    "<b>{0:.3f} px</b> over {1} views",  # at least FEWEST_VIEWS
    "view {0}, errors enlarged {1} times",  # ENLARGED
    "no more than {0} controls can be pinned; unpin one first",  # constants
    "no more than {0} values can be plotted at once; remove one first",
    "the colour did not settle within {0} steps; is the scene moving, or the lamp flickering?",
    "the light did not settle within {0} steps (it is at {1:.0%} of white);"
    " is the scene moving, or the lamp flickering?",
    "{0} was not acknowledged within {1} s ({2} tries)",  # several, see ControlTiming
    "{0} entries",  # of a lookup table
    "a trigger makes {0} frames instead of {1}; each frame waits for a trigger of its own: set"
    " TriggerMode[TriggerSelector=FrameStart] to Off",  # a mean, with its decimal
    "a trigger makes {0} frames instead of {1}; the acquisition ends before: check AcquisitionMode and"
    " AcquisitionFrameCount",
    "only {0} of {1} views were possible: give the arm more room, or move the target",  # 5 or more
    "only {0} of {1} poses show the target, {2} are wanted: move it, or take a smaller one",  # thousands
    "hand–eye calibration needs {0} views or more, not {1}",  # FEWEST_VIEWS
    "<b>{0} will move by itself</b> to {1} poses, one after another, for {2}.",  # 5 or more
    "The hand moves at up to {0:.0f} mm/s, first by {1} small moves of at most {2:.0f}°.",  # 5 or 6
    "{0}. The robot stands still. {1} poses were taken: compute from them, or start again",  # FEWEST_VIEWS
    "{0:.3f} px over {1} of {2} poses",  # FEWEST_VIEWS
    "{0:.1f} images/s · {1:.1f} MB/s",  # a rate, with its decimal
    "{0} needs {1} MB/s, more than its own cable carries ({2} MB/s)",  # a rate as well
    "{0} fps · {1} shown",  # of frames a second
    "{0} free",  # bytes, with their unit
    "{0} sends messages that are no images ({1})",  # names of ports and topics
    "{0} is subscribed to, and {1} sends nothing that arrives here",
}  # fmt: skip
"""Texts with a number before a plural that is never 1, or counts nothing."""
ENGLISH = re.compile(
    r"\b(the|of|and|is|are|to|with|for|from|this|that|show|shown|save|choose|image|frames?|sources?|open|"
    r"close|draw|record|recording|until|time|values?|here|once|again|what|where|camera's)\b",
    re.IGNORECASE,
)


@pytest.fixture
def spanish(qapp):
    speak(qapp, "es")
    yield
    speak(qapp, "en")


def texts_of(path):
    """Source texts with their translations; an unfinished one is None."""
    return {
        (context.findtext("name"), message.findtext("source")): (
            None if message.find("translation").get("type") else message.findtext("translation")
        )
        for context in ElementTree.parse(path).getroot().iter("context")
        for message in context.iter("message")
    }


def ours(widget):
    """Whether a widget's texts are the program's, and not the camera's or Qt's own."""
    while widget is not None:
        if isinstance(widget, (FeatureRow, Section)) or widget.objectName().startswith("qt_"):
            return False
        widget = widget.parent()
    return True


def shown(window):
    """Every text of the window that a person can read or hear, with where it stands."""
    for widget in window.findChildren(QWidget):
        if not ours(widget):
            continue
        name = f"{type(widget).__name__} {widget.objectName()}"
        yield name, widget.toolTip()
        yield name, widget.accessibleName()
        if isinstance(widget, (QLabel, QAbstractButton)):
            yield name, widget.text()
        if isinstance(widget, QLineEdit):
            yield name, widget.placeholderText()
        if isinstance(widget, QMenu):
            yield name, widget.title()
        if isinstance(widget, QDockWidget):
            yield name, widget.windowTitle()
        if isinstance(widget, QComboBox):
            yield from ((name, widget.itemText(index)) for index in range(widget.count()))
        if isinstance(widget, QTabBar):
            yield from ((name, widget.tabText(index)) for index in range(widget.count()))
    for action in window.findChildren(QAction):
        if ours(action.parent()):
            yield action.objectName(), action.text()
            yield action.objectName(), action.toolTip()


def test_nothing_of_the_window_stays_in_english(spanish, app):
    known = texts_of(TRANSLATIONS / "grabbergui_es.ts")
    english = {source for (_, source), text in known.items() if text != source}
    also_spanish = {text for text in known.values() if text}
    window = app.window
    app.connect()
    app.watch()
    for dock in window.findChildren(QDockWidget):
        dock.show()
    app.program.opener.open_additional("sim:colour?fps=15")
    app.until(lambda: len(window.gallery.tiles) == 2)
    window.recordingBar.recordButton.click()
    app.until(lambda: "imágenes" in window.recordingBar.progressLabel.text())
    app.until(lambda: "En directo" in window.status.stateLabel.text())
    window.actionPause.trigger()
    app.until(lambda: "En pausa" in window.status.stateLabel.text())
    window.recordingBar.recordButton.click()
    app.until(window.recordingBar.playButton.isVisible)
    dialog = ShortcutsDialog(window.menuBar(), window)
    wrong = {
        (where, text)
        for where, text in shown(window)
        if (text in english or ENGLISH.search(text)) and text not in also_spanish
    }
    dialog.close()
    assert not {(where, text) for where, text in wrong if not re.search("Simulated.camera", text)}


def test_what_the_models_say_is_translated_too(spanish, app):
    app.connect()
    app.watch()
    app.grabber.write_feature("TriggerMode", "On")
    state = app.window.status.stateLabel
    app.until(lambda: "Esperando disparo" in state.text())


@pytest.mark.parametrize("code", [code for code in languages() if code != "en"])
def test_every_text_is_translated_with_all_that_is_filled_in(code):
    known = texts_of(TRANSLATIONS / f"grabbergui_{code}.ts")
    unfinished = [source for source, text in known.items() if not text]
    assert not unfinished, "translate these, then run make translations"
    for (_, source), text in known.items():
        places = [
            sorted((name, spec) for _, name, spec, _ in string.Formatter().parse(t) if name is not None)
            for t in (source, text)
        ]
        assert places[0] == places[1], source


def nodes(path, call):
    """Return the syntax of a source file with such a call; most have none, and parsing takes long."""
    text = path.read_text("utf-8")
    return ast.walk(ast.parse(text)) if call in text else ()


@pytest.fixture(scope="module")
def counted_texts():
    """The texts of one and of several in each call of `counted`."""
    pairs = []
    for path in (p for room in TRANSLATED for p in room.rglob("*.py")):
        for call in nodes(path, "counted("):
            if not (isinstance(call, ast.Call) and getattr(call.func, "id", "") == "counted"):
                continue
            texts = [argument.args[-1].value for argument in call.args[1:3]]
            assert all(isinstance(text, str) for text in texts), f"{path}:{call.lineno}: texts as they are"
            pairs.append(tuple(texts))
    return pairs


@pytest.mark.parametrize("code", [code for code in languages() if code != "en"])
def test_every_counted_text_has_a_form_for_one(counted_texts, code):
    known = texts_of(TRANSLATIONS / f"grabbergui_{code}.ts")
    several = {many for _, many in counted_texts}
    uncounted = {
        source: text
        for (_, source), text in known.items()
        if (SEVERAL.search(source) or SEVERAL.search(text)) and source not in several | NO_COUNT
    }
    assert not uncounted, "let `counted` choose the form, or say in NO_COUNT why it is never one"
    assert {source for _, source in known} >= NO_COUNT, "texts that are no longer there"


@pytest.mark.parametrize("code", [code for code in languages() if code != "en"])
def test_the_form_for_one_is_another_text_that_is_singular(counted_texts, code):
    known = texts_of(TRANSLATIONS / f"grabbergui_{code}.ts")
    assert len(counted_texts) >= 15
    for pair in counted_texts:
        texts = [[text for (_, source), text in known.items() if source == each] for each in pair]
        assert all(texts), pair
        for one, many in zip(*texts, strict=True):
            assert one != many and "{0}" not in one and "{0}" in many, pair
            assert not SEVERAL.search(one), one


@pytest.mark.parametrize("code", [code for code in languages() if code != "en"])
def test_the_file_that_is_loaded_is_of_these_texts(qapp, code):
    try:
        speak(qapp, code)
        for (context, source), text in texts_of(TRANSLATIONS / f"grabbergui_{code}.ts").items():
            assert QCoreApplication.translate(context, source) == text, "run make translations"
    finally:
        speak(qapp, "en")


def test_no_text_of_the_sources_is_missing(tmp_path):
    """Texts are looked for as `make translations` does."""
    update = Path(sys.executable).parent / "pylupdate5"
    if not update.exists():
        pytest.skip("pylupdate5 is not beside this Python")
    files = [str(p) for room in TRANSLATED for p in room.rglob("*") if p.suffix in (".py", ".ui")]
    target = tmp_path / "found.ts"
    subprocess.run([str(update), *files, "-ts", str(target)], check=True, capture_output=True)
    missing = texts_of(target).keys() - texts_of(TRANSLATIONS / "grabbergui_es.ts").keys()
    assert not missing, "run make translations, and translate these"


def test_no_call_of_the_sources_is_missing():
    """Read as Python reads them: pylupdate5 passes over some calls."""
    known = texts_of(TRANSLATIONS / "grabbergui_es.ts")
    missing = []
    for path in (path for folder in TRANSLATED for path in folder.rglob("*.py")):
        for node in nodes(path, "translate("):
            if not isinstance(node, ast.Call) or "translate" not in (
                getattr(node.func, "id", ""),
                getattr(node.func, "attr", ""),
            ):
                continue
            words = tuple(arg.value for arg in node.args[:2] if isinstance(arg, ast.Constant))
            if len(words) == 2 and words not in known:
                missing.append(f"{path.name}:{node.lineno}: {words[1]}")
    assert not missing, "run make translations, and translate these"


def test_clipping_is_not_called_as_the_saturation_of_colours_is():
    known = texts_of(TRANSLATIONS / "grabbergui_es.ts")
    of_clipping = [text for (_, source), text in known.items() if "clip" in source.lower()]
    assert of_clipping and not [text for text in of_clipping if "saturación" in text.lower()]


@pytest.mark.parametrize("code", languages())
def test_mnemonics_of_a_menu_differ(qapp, code, request):
    speak(qapp, code)
    request.addfinalizer(lambda: speak(qapp, "en"))
    app = request.getfixturevalue("app")
    menubar = app.window.menuBar()
    menus = [menubar, *(menu for menu in menubar.findChildren(QMenu) if menu.actions())]
    for menu in menus:
        texts = [action.text().replace("&&", "") for action in menu.actions() if "&" in action.text()]
        keys = [text[text.index("&") + 1].lower() for text in texts]
        assert len(keys) == len(set(keys)), texts


def test_a_language_that_there_is_not_is_refused(qapp):
    with pytest.raises(UsageError, match="there are en, es"):
        speak(qapp, "xx")


@pytest.mark.parametrize(
    ("desktop", "spoken"),
    [(["es-ES"], "es"), (["ca", "es-419"], "es"), (["de-DE"], "en"), (["en-GB", "es"], "en"), ([], "en")],
)
def test_the_language_follows_the_desktop(qapp, monkeypatch, desktop, spoken):
    monkeypatch.setattr(QLocale, "uiLanguages", lambda self: desktop)
    try:
        assert speak(qapp) == spoken
        assert (models_language.translate("Diagnosis", "See the log.") != "See the log.") == (spoken == "es")
    finally:
        speak(qapp, "en")


def test_numbers_have_the_languages_decimal_point(spanish, app):
    window = app.window
    app.connect()
    app.watch()
    for dock in (window.focusDock, window.histogramDock):
        dock.show()
        dock.raise_()
        app.qtbot.wait(50)
    window.actionClipping.trigger()
    window.actionPause.trigger()
    app.program.open_sources.current.features.write("Gain", 7.5)
    gain = window.favourites.rows.rows("Gain")[0]
    app.until(lambda: gain.editor is not None and gain.editor.field.text() == "7,5 dB")
    app.until(lambda: "," in window.histogram.figuresLabel.text())
    app.until(lambda: "," in window.status.rateLabel.text())
    app.until(lambda: "," in window.status.clippingButton.text())
    labels = [label for label in window.findChildren(QLabel) if label.isVisible() and ours(label)]
    wrong = {label.objectName(): label.text() for label in labels if re.search(r"\d\.\d", label.text())}
    assert not wrong


def test_the_axes_of_a_plot_have_the_languages_decimal_point(spanish, qtbot):
    made = ChannelPlot()
    qtbot.addWidget(made)
    for side in ("left", "bottom"):
        assert made.getAxis(side).tickStrings([1.5, 1.6], 1.0, 0.1) == ["1,5", "1,6"]


def test_the_keys_stand_apart_from_their_text_and_the_dialog_fits_a_small_screen(spanish, app):
    dialog = ShortcutsDialog(app.window.menuBar(), app.window)
    dialog.show()
    text = dialog.leftLabel.text() + dialog.rightLabel.text()
    assert "Ctrl+Mayús+S" in text and "Mayúsculas" not in text and "Shift" not in text
    screen = dialog.screen().availableSize()
    assert dialog.height() < screen.height() and dialog.width() < screen.width()
    needed = dialog.content.heightForWidth(dialog.content.width()) + dialog.closeButton.height()
    assert dialog.height() >= min(needed, 0.85 * screen.height()), "no smaller than it has to be"
    assert dialog.closeButton.isVisible() and dialog.rect().contains(dialog.closeButton.geometry())
    dialog.close()

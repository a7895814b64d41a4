"""Text from outside on the screen: the window shows it as it is, and never as rich text.

The camera's every text is HTML. The walk finds each place of the window that would render it; a look at the
source finds calls that bypass `ui.shown_text`, whether a test shows them or not.
"""

import ast
import json
from pathlib import Path

import pyqtgraph as pg
import pytest
from PyQt5.QtCore import QPoint, Qt
from PyQt5.QtGui import QTextDocument
from PyQt5.QtWidgets import (
    QAction,
    QApplication,
    QComboBox,
    QLabel,
    QTextBrowser,
    QWidget,
)

import made_dialogs
from every_case import every_case
from grabbergui import ui
from grabbergui.models.diagnosis import Stage
from grabbergui.models.markup import Markup, joined, markup, table
from grabbergui.models.sources import ListedSource
from grabbergui.models.status import Tone
from grabbergui.ui.shown_text import (
    MOST_TIP,
    PlainLabel,
    add_to_tooltip,
    name_axis,
    plain,
    question_box,
    set_plot_title,
    set_rich,
    set_tooltip,
    tooltip_of,
)
from grabbergui.ui.views.feature_panel import Section
from grabbergui.ui.views.main_window import MainWindow
from grabbergui.ui.views.settings_dialogs import SettingsReport
from grabbergui.ui.views.user_sets_dialog import UserSetsDialog
from marked_camera import MARKUP, marked_camera, marked_info
from shown_walk import RAW, rendered, walk

PACKAGE = Path(ui.__file__).parents[1]


def open_dialog(app, kind):
    """Wait for a dialog of a kind, and return it."""
    shown = lambda: [each for each in QApplication.topLevelWidgets() if isinstance(each, kind)]  # noqa: E731
    app.until(shown)
    return shown()[0]


def test_the_window_renders_no_text_of_the_camera(app, monkeypatch, tmp_path):
    window, program = app.window, app.program
    monkeypatch.setattr(program.opener, "create", lambda uri: marked_camera(uri, MARKUP))
    app.connect("sim:")
    panel = window.features
    panel.levelBox.setCurrentText("Guru")
    for section in panel.findChildren(Section):
        if not section.open:
            section.header.click()
    features = program.open_sources.current.features
    app.until(lambda: features.feature("ExposureAuto") and features.feature("DeviceVendorName"))
    exposure = window.favourites.rows
    app.until(lambda: [r for r in exposure.rows("ExposureTime") if r.auto and r.auto.isEnabled()])
    features.write("DeviceUserID", "<b>X</b>")
    features.write("ExposureTime", -5.0)
    app.until(lambda: app.errors and window.changes.table.model().rowCount())
    program.messages.error(MARKUP)
    window.image.setNote(MARKUP, MARKUP, Stage.CONTROL)
    window.image.tasks.begin(MARKUP).setText(MARKUP)
    window.sources.setSources([ListedSource(marked_info(MARKUP, f"sim:{MARKUP}"), manual=True)])
    window.recordingBar.setPlayable(MARKUP)
    window.status.setLosses(MARKUP, Tone.BAD, MARKUP)
    program.feature_controls.values.plot(features.description("ExposureTime"))
    program.feature_controls.feature_menu._on_menu_requested("ExposureTime", QPoint())
    settings = tmp_path / f"{MARKUP.replace('/', '_')}.yaml"
    settings.write_text(f"features:\n  DeviceUserID: {json.dumps(MARKUP)}\n", "utf-8")
    program.feature_controls.settings_files.compare(settings)
    report = open_dialog(app, SettingsReport)
    window.actionUserSets.trigger()
    user_sets = open_dialog(app, UserSetsDialog)
    app.until(user_sets.setList.count)

    found = walk()
    assert not found.found, "\n".join(found.found)
    assert found.longest < 10_000, "of a camera's 100,000 characters"
    assert found.places >= {"toolTip", "label", "cell", "cell's tooltip", "action's tooltip"}
    for dialog in (report, user_sets):
        dialog.close()


def question(window):
    return question_box(window, MARKUP, MARKUP)


def plot(window):
    made = pg.PlotWidget(window)
    name_axis(made, "left", MARKUP)
    set_plot_title(made, markup("<b>{0}</b>", MARKUP))
    return made


@pytest.fixture
def window(qtbot):
    made = MainWindow()
    qtbot.addWidget(made)
    return made


@every_case("make", [*made_dialogs.MADE.values(), question, plot])
def test_no_dialog_renders_text_from_outside(window, monkeypatch, make):
    monkeypatch.setattr(made_dialogs, "LONG", MARKUP)
    made = make(window)
    found = walk(made)
    assert not found.found, "\n".join(found.found)
    if make in (question, plot):
        assert found.places
    made.close()


def test_the_walk_finds_what_is_rendered(qtbot):
    window = QWidget()
    qtbot.addWidget(window)
    label = QLabel(MARKUP, window)
    box = QComboBox(window)
    box.addItem("one")
    box.setItemData(0, MARKUP, Qt.ItemDataRole.ToolTipRole)
    box.setToolTip(MARKUP)
    QAction(MARKUP, window)
    browser = QTextBrowser(window)
    browser.setHtml(MARKUP)
    axis = pg.PlotWidget(window)
    axis.setLabel("left", MARKUP)
    found = "\n".join(walk(window).found)
    for place in (
        "label of QLabel",
        "cell's tooltip",
        "toolTip of QComboBox",
        "action's",
        "document",
        "graphics",
    ):
        assert place in found
    label.setTextFormat(Qt.PlainText)
    assert "label of QLabel" not in "\n".join(walk(window).found)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "plain",
        "1 < 2 and 3 > 2",
        MARKUP,
        f"{MARKUP}\n<b>",
        f"\n{MARKUP}",
        "&lt;b>",
        "<!doctype x",
        "<?xml?><b>x",
    ],
)
def test_a_tooltip_shows_the_text_itself(qtbot, text):
    label = PlainLabel()
    qtbot.addWidget(label)
    set_tooltip(label, text)
    shown = label.toolTip()
    if Qt.mightBeRichText(shown):
        document = QTextDocument()
        document.setHtml(shown)
        shown = document.toPlainText()
    assert shown == text


def test_a_reason_below_a_tooltip_is_escaped_too(qtbot):
    label = PlainLabel()
    qtbot.addWidget(label)
    for purpose in (MARKUP, "plain"):
        set_tooltip(label, purpose)
        add_to_tooltip(label, tooltip_of(label), MARKUP)
        assert MARKUP in label.toolTip() if purpose == "plain" else RAW not in label.toolTip()
        assert not rendered(label.toolTip())


def test_a_tooltip_has_an_end():
    assert len(plain("x" * 1_000_000)) == MOST_TIP + 1


def test_markup_escapes_all_but_markup(qtbot):
    bold = markup("<b>{0}</b>{1:.1f}", "<i>", 2)
    assert bold == "<b>&lt;i&gt;</b>2.0" and isinstance(bold, Markup)
    assert joined([bold, "<"], "<br>") == f"{bold}<br>&lt;"
    assert table([("<", bold)]) == f"<table><tr><td>&lt;&nbsp;&nbsp;</td><td>{bold}</td></tr></table>"
    label = PlainLabel("<b>")
    qtbot.addWidget(label)
    assert label.textFormat() == Qt.PlainText
    set_rich(label, bold)
    assert label.textFormat() == Qt.RichText


BYPASSING = {
    "setToolTip", "setWhatsThis", "setTextFormat", "setInformativeText", "setLabel",
    "setHtml", "insertHtml", "appendHtml", "setMarkdown", "QTextDocument",
    "QLabel", "QMessageBox", "QErrorMessage", "QInputDialog", "QProgressDialog", "QToolTip", "QWhatsThis",
    "QStaticText", "QGraphicsTextItem", "QSystemTrayIcon", "TextItem", "LabelItem",
}  # fmt: skip
"""Calls of these decide how Qt takes a text: they belong into `ui.shown_text`."""
SHOWING = {"QMessageBox", "QInputDialog", "QErrorMessage", "QToolTip", "QWhatsThis"}
"""Classes with functions that show text."""


def bypassing(source):
    """Return the lines with such a call, and those with a class derived from QLabel."""
    if not any(word in source for word in BYPASSING | SHOWING):
        return []  # parsing takes long
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Call):
            name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            owner = node.func.value if isinstance(node.func, ast.Attribute) else None
            if name in BYPASSING or getattr(owner, "id", "") in SHOWING:
                found.append(node.lineno)
        if isinstance(node, ast.ClassDef) and any(getattr(base, "id", "") == "QLabel" for base in node.bases):
            found.append(node.lineno)
    return sorted(found)


def test_no_view_decides_by_itself_how_text_is_shown():
    calls = ("self.setToolTip(x)", "QLabel(x)", "QMessageBox.about(x)", "pg.TextItem(x)")
    source = "\n".join((*calls, "class A(QLabel): pass", "set_tooltip(self, x)"))
    assert bypassing(source) == [1, 2, 3, 4, 5]
    found = {
        f"{file.relative_to(PACKAGE)}:{line}"
        for file in PACKAGE.rglob("ui/**/*.py")
        if file.name != "shown_text.py"
        for line in bypassing(file.read_text("utf-8"))
    }
    assert not found, "show text with grabbergui.ui.shown_text"


def test_no_form_decides_how_text_is_shown():
    for form in PACKAGE.rglob("forms/*.ui"):
        assert "textFormat" not in form.read_text("utf-8"), form

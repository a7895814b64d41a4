"""Forms are compiled once, and again after a change."""

import os
import re
import sys
from itertools import combinations
from xml.etree import ElementTree

import pytest
from PyQt5 import uic
from PyQt5.QtWidgets import QWidget

from every_case import every_case
from grabbergui.core.environment import RESOURCES
from grabbergui.ui import form_loader
from grabbergui.ui.form_loader import compile_forms, load_form

FORM = """<ui version="4.0"><class>Card</class><widget class="QWidget" name="Card">
<layout class="QVBoxLayout" name="lines"><item><widget class="QPushButton" name="saveButton">
<property name="text"><string>{text}</string></property>
<property name="iconName" stdset="0"><string notr="true">{icon}</string></property></widget></item></layout>
</widget><connections/></ui>"""


@pytest.fixture
def forms(tmp_path, monkeypatch):
    (folder := tmp_path / "forms").mkdir()
    monkeypatch.setattr(form_loader, "FORMS", folder)
    monkeypatch.setattr(form_loader, "PACKAGE", tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    form_loader.form_class.cache_clear()
    yield folder
    form_loader.form_class.cache_clear()


def loaded(qtbot):
    """Load the form as a program does that starts now."""
    form_loader.form_class.cache_clear()
    card = QWidget()
    qtbot.addWidget(card)
    load_form("card", card)
    return card


def test_children_are_attributes_and_have_their_icons(qtbot, forms):
    (forms / "card.ui").write_text(FORM.format(text="Save", icon="record"))
    card = loaded(qtbot)
    assert card.saveButton.parent() is card
    assert card.saveButton.text() == "Save"
    assert not card.saveButton.icon().isNull()


def test_a_form_is_compiled_once_and_anew_after_a_change(qtbot, forms, monkeypatch):
    path, compiled = forms / "card.ui", []
    compile_ui = uic.compileUi
    monkeypatch.setattr(uic, "compileUi", lambda *given: (compiled.append(1), compile_ui(*given)))
    path.write_text(FORM.format(text="Save", icon="record"))
    cards = [loaded(qtbot), loaded(qtbot)]
    assert [card.saveButton.text() for card in cards] == ["Save", "Save"]
    assert len(compiled) == 1
    path.write_text(FORM.format(text="Keep", icon="record"))
    os.utime(path, (0, 0))
    card = loaded(qtbot)
    assert card.saveButton.text() == "Keep"
    assert len(compiled) == 2


def test_all_forms_can_be_compiled_before_they_are_needed(forms):
    (forms / "card.ui").write_text(FORM.format(text="Save", icon="record"))
    compile_forms()
    assert [file.name.split(".")[0] for file in (forms / "__pycache__").iterdir()] == ["card"]


PAGES = ("QStackedWidget", "QTabWidget")


def texts(widget, pages=frozenset()):
    """Yield the texts with a letter below a widget, and the pages of stacks on which each one is."""
    for child in widget:
        if child.tag == "widget":
            own = {(widget.get("name"), child.get("name"))} if widget.get("class") in PAGES else set()
            if child.get("class") not in ("QMenu", "QMenuBar"):
                yield from texts(child, pages | own)
        elif child.tag in ("layout", "item"):
            yield from texts(child, pages)
        elif child.get("name") in ("text", "title") and "&" in (text := child.findtext("string") or ""):
            yield text, pages


def spanish(form):
    """Return the translations of a form."""
    file = ElementTree.parse(RESOURCES / "translations" / "grabbergui_es.ts")
    contexts = (each for each in file.iter("context") if each.findtext("name") == form)
    return {m.findtext("source"): m.findtext("translation") for c in contexts for m in c.iter("message")}


@every_case("file", sorted(form_loader.FORMS.glob("*.ui")), ids=lambda file: file.stem)
def test_a_letter_presses_one_control(file):
    """Alt+N moved the cursor to a field instead of pressing Next."""
    form = ElementTree.parse(file).getroot()
    for translate in (lambda text: text, spanish(form.findtext("class")).get):
        letters = [
            (re.search(r"&(\w)", translate(text))[1].lower(), pages)
            for text, pages in texts(form.find("widget"))
        ]
        for (one, at), (other, there) in combinations(letters, 2):
            apart = any(a == b and page != beside for a, page in at for b, beside in there)
            assert apart or one != other, f"Alt+{one} in {[text for text, _ in texts(form.find('widget'))]}"

"""Editors on screen, and what came out of them."""

import pytest
from PyQt5.QtWidgets import QLabel

from grabbergui.ui.editors.feature_row import editor_class


class Hand:
    """An editor on screen, and what it emitted."""

    def __init__(self, qtbot, editor, shown):
        self.editor = editor
        qtbot.addWidget(editor)
        self.values, self.holds = [], []
        editor.valueEdited.connect(self.values.append)
        editor.editingStarted.connect(lambda: self.holds.append("start"))
        editor.editingFinished.connect(lambda: self.holds.append("finish"))
        editor.setFeature(shown)
        if editor.slider() is not None:
            editor.slider().resize(200, 24)
            editor.slider().show()
        editor.resize(200, 30)
        editor.show()
        qtbot.waitExposed(editor)

    @property
    def hints(self):
        """The texts below the editor's control that say why a typed value was not taken."""
        return [label.text() for label in self.editor.findChildren(QLabel, "hint") if label.isVisible()]


@pytest.fixture
def take(qtbot):
    """Put editors on screen."""
    return lambda shown: Hand(qtbot, editor_class(shown)(), shown)

"""The manual, the list of shortcuts, and the log."""

from __future__ import annotations

import logging
import re
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from PyQt5.QtCore import QSize, Qt, QUrl, pyqtSignal
from PyQt5.QtGui import QDesktopServices, QImage, QKeySequence
from PyQt5.QtWidgets import (
    QAction,
    QApplication,
    QComboBox,
    QDialog,
    QHBoxLayout,
    QLabel,
    QLayout,
    QMenu,
    QMenuBar,
    QPlainTextEdit,
    QPushButton,
    QScrollArea,
    QTextBrowser,
    QVBoxLayout,
    QWidget,
)

from grabbergui.core.visible_text import shortened, visible
from grabbergui.models.log_book import MOST_LOG_LINES, LogLine
from grabbergui.models.markup import Markup, joined, markup
from grabbergui.models.unavailable import Unavailable
from grabbergui.ui.actions import set_available
from grabbergui.ui.dialog_style import dress_dialog
from grabbergui.ui.form_loader import load_form
from grabbergui.ui.screen import fit_screen
from grabbergui.ui.shown_text import set_rich

FIRST_PAGE = "window.md"
SIZE = QSize(820, 640)
IMAGE_WIDTH = 740

_PICTURE = re.compile(r'<picture>.*?<img src="([^"]*)" alt="([^"]*)">\s*</picture>', re.DOTALL)
"""Qt's Markdown ends at HTML that it does not know."""
KEY_WIDTH = 110
"Pixels of the keys' column at least, the same in every table."
SCROLL_BAR = 20
"Pixels that the scroll bar may take beside the tables."
MOST_OF_SCREEN = 0.9
"Share of the screen's width and height."
KEY_GAP = Markup("&nbsp;" * 4)
"Space behind the keys: Qt's rich text has no padding of cells."
_LEVELS = (logging.NOTSET, logging.WARNING, logging.ERROR)
MOST_LINE = 4000
"Characters of a line; peers write messages."


class ManualBrowser(QTextBrowser):
    """Shows Markdown pages, with pictures scaled to fit, also those in HTML."""

    def loadResource(self, kind: int, name: QUrl) -> Any:
        """Read a page or an image from its file."""
        path = Path(self.source().resolved(name).toLocalFile())
        if path.suffix == ".md":
            return _PICTURE.sub(r"![\2](\1)", path.read_text("utf-8"))
        image = QImage(str(path))
        if image.width() <= IMAGE_WIDTH:
            return image
        return image.scaledToWidth(IMAGE_WIDTH, Qt.TransformationMode.SmoothTransformation)


class ManualDialog(QDialog):
    """The pages of the manual, with links between them; others open in the desktop's browser."""

    def __init__(self, folder: Path, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle(self.tr("Manual"))
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.text = ManualBrowser(self)
        self.text.setAccessibleName(self.tr("Manual"))
        self.text.setOpenLinks(False)
        self.text.anchorClicked.connect(self._follow)
        self.text.setSource(QUrl.fromLocalFile(str(folder / FIRST_PAGE)))
        back = QPushButton(self.tr("&Back"), self)
        back.setAutoDefault(False)
        set_available(back, Unavailable.PAGE)
        back.clicked.connect(self.text.backward)
        self.text.backwardAvailable.connect(
            lambda can: set_available(back, None if can else Unavailable.PAGE)
        )
        layout = QVBoxLayout(self)
        layout.addWidget(self.text)
        close = QPushButton(self.tr("Close"), self)
        close.setDefault(True)
        close.clicked.connect(self.reject)
        buttons = QHBoxLayout()
        buttons.addWidget(back)
        buttons.addStretch(1)
        buttons.addWidget(close)
        layout.addLayout(buttons)
        dress_dialog(self)
        self.resize(SIZE)
        fit_screen(self)

    def _follow(self, link: QUrl) -> None:
        target = self.text.source().resolved(link)
        if target.isLocalFile() and Path(target.toLocalFile()).suffix == ".md":
            self.text.setSource(target)
        else:
            QDesktopServices.openUrl(target)


class ShortcutsDialog(QDialog):
    """The keys of all menus in two columns; deleted when it is closed."""

    scrollArea: QScrollArea
    content: QWidget
    leftLabel: QLabel
    rightLabel: QLabel
    closeButton: QPushButton

    def __init__(self, menubar: QMenuBar, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("shortcuts_dialog", self)
        tables = [table for action in menubar.actions() if (table := self._table(action.menu()))]
        columns = [Markup(), Markup()]
        # Columns of equal height: the longest menu first, each into the shorter column.
        for table in sorted(tables, key=_height, reverse=True):
            shorter = _height(columns[1]) < _height(columns[0])
            columns[shorter] = joined([columns[shorter], table])
        set_rich(self.leftLabel, columns[0])
        set_rich(self.rightLabel, columns[1])
        self.closeButton.clicked.connect(self.accept)
        self._take_room()

    def _take_room(self) -> None:
        """Show everything at once where the screen has room for it; else it is scrolled."""
        for layout in (*self.content.findChildren(QLayout), self.layout()):
            if layout is not None:
                layout.activate()  # only then does each know the size of what it holds
        hint = self.content.sizeHint()
        width = hint.width() + SCROLL_BAR
        wanted = QSize(width, self.content.heightForWidth(width)) + self.size() - self.scrollArea.size()
        screen = self.screen()
        self.resize(wanted.boundedTo(screen.availableSize() * MOST_OF_SCREEN) if screen else wanted)

    def _table(self, menu: QMenu | None) -> Markup:
        if menu is None:
            return Markup()
        rows = joined(
            markup(
                "<tr><td width='{0}' style='white-space:pre'><b>{1}</b>{2}</td><td>{3}</td></tr>",
                KEY_WIDTH,
                self._keys(action.shortcut()),
                KEY_GAP,
                _plain(action.iconText()),
            )
            for action in _actions(menu)
            if not action.shortcut().isEmpty()
        )
        return markup("<h3>{0}</h3><table>{1}</table>", _plain(menu.title()), rows) if rows else Markup()

    def _keys(self, keys: QKeySequence) -> str:
        """Return the keys as printed on a keyboard; Qt would write *Mayúsculas* for Shift."""
        return keys.toString(QKeySequence.PortableText).replace("Shift", self.tr("Shift"))


def _height(tables: str) -> int:
    """Lines of some tables: their rows, and as much as two for each title."""
    return tables.count("<tr>") + 2 * tables.count("<h3>")


def _actions(menu: QMenu) -> Iterator[QAction]:
    for action in menu.actions():
        inner = action.menu()
        if inner is not None:
            yield from _actions(inner)
        else:
            yield action


def _plain(text: str) -> str:
    return text.replace("&", "").rstrip("…")


class LogPanel(QWidget):
    """Shows entries, the newest last, and scrolls to them unless the user scrolled up."""

    levelChanged = pyqtSignal()
    """The user chose another level; `setLines` is expected."""
    clearRequested = pyqtSignal()

    levelBox: QComboBox
    copyButton: QPushButton
    clearButton: QPushButton
    text: QPlainTextEdit

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("log_panel", self)
        self.text.setMaximumBlockCount(MOST_LOG_LINES)
        self.levelBox.currentIndexChanged[int].connect(lambda _: self.levelChanged.emit())
        self.clearButton.clicked.connect(self.clearRequested)
        self.copyButton.clicked.connect(self._on_copy_clicked)

    def setLines(self, lines: Sequence[LogLine]) -> None:
        """Show the entries of the chosen level and above."""
        self.text.setPlainText("\n".join(_text(line) for line in lines if self._shown(line)))
        if (bar := self.text.verticalScrollBar()) is not None:
            bar.setValue(bar.maximum())

    def addLine(self, line: LogLine) -> None:
        """Add an entry."""
        if self._shown(line):
            bar = self.text.horizontalScrollBar()
            before = bar.value() if bar is not None else 0
            self.text.appendPlainText(_text(line))
            if bar is not None:
                bar.setValue(before)  # Qt would show the end of a long line

    def _shown(self, line: LogLine) -> bool:
        return line.level >= _LEVELS[self.levelBox.currentIndex()]

    def _on_copy_clicked(self) -> None:
        if (clipboard := QApplication.clipboard()) is not None:
            clipboard.setText(self.text.toPlainText())


def _text(line: LogLine) -> str:
    shown = "\n".join(shortened(visible(each), MOST_LINE) for each in line.text.split("\n"))
    moment = time.strftime("%H:%M:%S", time.localtime(line.time))
    milliseconds = int(line.time * 1000) % 1000
    return f"{moment}.{milliseconds:03d}  {logging.getLevelName(line.level):<8} {line.origin}: {shown}"

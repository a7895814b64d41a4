"""The panel of all features: sections by category that fold, filled over several turns of the event loop."""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Iterator
from functools import partial

from PyQt5.QtCore import QEvent, QObject, QPoint, Qt, pyqtSignal
from PyQt5.QtGui import QKeyEvent, QResizeEvent
from PyQt5.QtWidgets import (
    QComboBox,
    QLabel,
    QLineEdit,
    QMenu,
    QPushButton,
    QSizePolicy,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from grabbergui.core.features import Category, Feature, FeatureDescription, Visibility
from grabbergui.models.features.filtering import visible_names
from grabbergui.models.language import counted
from grabbergui.models.unavailable import Unavailable
from grabbergui.ui.actions import set_available
from grabbergui.ui.editors.feature_row import FeatureRow, FeatureRows
from grabbergui.ui.form_loader import load_form
from grabbergui.ui.gui_thread import Pacer
from grabbergui.ui.shown_text import set_tooltip

MakeRow = Callable[[FeatureDescription, QWidget, bool], FeatureRow]
"""Makes a row from a description, its parent, and whether it stands below its selector."""
MOST_FOUND = 200
"""Most rows that a search shows; another letter narrows it down."""
_LEVELS = (Visibility.BEGINNER, Visibility.EXPERT, Visibility.GURU)


class _Header(QToolButton):
    """A category's title and whether it is open; shortened where there is no room for all of it."""

    def __init__(self, category: Category) -> None:
        super().__init__()
        self._title = category.title
        self.setAccessibleName(category.title)
        set_tooltip(self, "\n".join(text for text in (category.title, category.tooltip) if text))
        self.setAutoRaise(True)
        self.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        font = self.font()
        font.setBold(True)
        self.setFont(font)
        self.setText(self._title)

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Fit the title."""
        room = self.width() - 2 * self.iconSize().width()
        self.setText(self.fontMetrics().elidedText(self._title, Qt.TextElideMode.ElideRight, room))
        super().resizeEvent(event)


class Section(QWidget):
    """A header and, below it, rows and further sections.

    superqt's QCollapsible fixes the height of what it holds, to animate it; here the content grows.
    """

    toggled = pyqtSignal()
    """The user opened or closed this section or one below."""
    allRequested = pyqtSignal(bool)
    """The user wants to open or close all sections of the tree."""

    def __init__(
        self,
        category: Category,
        make_row: MakeRow,
        pacer: Pacer,
        opened: frozenset[str] = frozenset(),
        parent: QWidget | None = None,
    ) -> None:
        """Open at first if it holds a feature of `opened`."""
        super().__init__(parent)
        self.category = category
        self._opened = opened
        self.names = frozenset(description.name for description in category.descriptions())
        self._own = {m.name for m in category.members if not isinstance(m, Category)}
        self._make_row = make_row
        self._pacer = pacer
        self._parts: dict[int, Section | FeatureRow] = {}
        self._shown: frozenset[str] = frozenset()
        self._searching = False
        self.header = _Header(category)
        self.header.clicked.connect(self._on_header_clicked)
        self.header.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.header.customContextMenuRequested.connect(self._on_header_menu_requested)
        self._open = bool(self.names & opened)
        self._body = QWidget()
        self._body_layout = QVBoxLayout(self._body)
        self._body_layout.setContentsMargins(10, 2, 0, 6)
        self._body_layout.setSpacing(2)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addWidget(self.header)
        layout.addWidget(self._body)
        self._update_open()

    def removeHeader(self) -> None:
        """Stay open, without header or margins: the root of a tree."""
        self.setOpen(True)
        self.header.hide()
        self._body_layout.setContentsMargins(0, 0, 0, 0)

    @property
    def open(self) -> bool:
        """Whether the rows can be seen: the user opened it, or a search found something below."""
        return self._searching or self._open

    def setOpen(self, opened: bool) -> None:
        """Open or close; `arrange` follows."""
        self._open = opened

    def setAllOpen(self, opened: bool) -> None:
        """Open or close all sections below, also those not made yet; `arrange` follows."""
        self._opened = self.names if opened else frozenset()
        for part in self._parts.values():
            if isinstance(part, Section):
                part.setOpen(opened)
                part.setAllOpen(opened)

    def arrange(self, shown: frozenset[str], searching: bool) -> None:
        """Show the features of these names, and no others; all open while somebody searches."""
        self._shown = shown & self.names
        self._searching = searching
        self.setVisible(bool(self._shown))
        self._update_open()
        if not self._shown:
            return
        for index, member in enumerate(self.category.members):
            if isinstance(member, Category):
                self._arrange_section(index, member)
            else:
                self._arrange_row(index, member)

    def names_on_show(self) -> Iterator[str]:
        """Names of the features whose rows can be seen, also those not made yet."""
        if not self.open:
            return
        for index, member in enumerate(self.category.members):
            part = self._parts.get(index)
            if isinstance(part, Section):
                yield from part.names_on_show()
            elif member.name in self._shown:
                yield member.name

    def _arrange_section(self, index: int, category: Category) -> None:
        part = self._parts.get(index)
        if part is None and self.open:
            part = Section(category, self._make_row, self._pacer, self._opened, self._body)
            part.toggled.connect(self.toggled)
            part.allRequested.connect(self.allRequested)
            self._place(index, part)
        if isinstance(part, Section):
            part.arrange(self._shown, self._searching)

    def _arrange_row(self, index: int, description: FeatureDescription) -> None:
        shown = description.name in self._shown
        part = self._parts.get(index)
        if part is not None:
            part.setVisible(shown)
        elif shown and self.open:
            self._pacer.add((self, index), lambda: self._build_row(index, description))

    def _build_row(self, index: int, description: FeatureDescription) -> None:
        if index in self._parts or not self.open or description.name not in self._shown:
            return
        indented = any(selector in self._own for selector in description.selectors)
        self._place(index, self._make_row(description, self._body, indented))

    def _place(self, index: int, part: Section | FeatureRow) -> None:
        position = sum(1 for other in self._parts if other < index)
        self._parts[index] = part
        # Below what can be seen until the layout has a place for it: a window may be painted before that,
        # and new rows would be painted over each other.
        part.move(0, self._body.height())
        self._body_layout.insertWidget(position, part)
        part.show()

    def _update_open(self) -> None:
        self.header.setArrowType(Qt.ArrowType.DownArrow if self.open else Qt.ArrowType.RightArrow)
        self._body.setVisible(self.open)

    def _on_header_menu_requested(self, place: QPoint) -> None:
        menu = QMenu(self)  # not the header's own actions, for which Qt would draw an arrow
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        menu.addAction(self.tr("Expand all"), partial(self.allRequested.emit, True))
        menu.addAction(self.tr("Collapse all"), partial(self.allRequested.emit, False))
        menu.popup(self.header.mapToGlobal(place))

    def _on_header_clicked(self) -> None:
        self.setOpen(not self._open)
        self.toggled.emit()


class FeaturePanel(QWidget):
    """Sections with a row for each feature, a filter, and the choice of a visibility level.

    Rows are made when their section is first opened, a few milliseconds a turn of the event loop.
    """

    watchedChanged = pyqtSignal(frozenset)
    """Names of the features that can be seen."""

    filterEdit: QLineEdit
    levelBox: QComboBox
    messageLabel: QLabel
    moreButton: QPushButton
    content: QWidget
    sections: QVBoxLayout

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("feature_panel", self)
        self.rows = FeatureRows(self)
        """Every row; signals report what the user does in them."""
        self._pacer = Pacer(self)
        self._section: Section | None = None
        self._camera: Hashable = None
        self._sections: dict[Hashable, Section] = {}
        "Sections of cameras that may be shown again."
        self._watched: frozenset[str] = frozenset()
        self._elsewhere: frozenset[str] = frozenset()
        self.filterEdit.textChanged.connect(self._arrange)
        self.levelBox.currentIndexChanged[int].connect(self._arrange)
        self.moreButton.clicked.connect(lambda: self.levelBox.setCurrentIndex(_LEVELS.index(Visibility.GURU)))
        self.filterEdit.installEventFilter(self)
        self._arrange()

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Clear the filter on Escape; of an empty one it leaves the field, as of any other."""
        if (
            isinstance(event, QKeyEvent)
            and event.type() == QEvent.Type.KeyPress
            and event.key() == Qt.Key.Key_Escape
            and self.filterEdit.text()
        ):
            self.filterEdit.clear()
            return True
        return super().eventFilter(watched, event)

    def setTree(self, root: Category | None, opened: Collection[str] = (), camera: Hashable = None) -> None:
        """Show another camera's features, or none.

        Sections that hold a feature of `opened` are open at first, or else the first section. The rows of a
        `camera` are kept until `forget`, and shown as they were left when it comes back with the same `root`.
        """
        self._pacer.clear()
        if self._section is not None:
            self._section.hide()
        if self._camera is None:
            self.forget(None)
        self._camera = camera
        self._section = self._sections.get(camera)
        if self._section is not None and self._section.category is not root:
            self.forget(camera)
        self.rows.turnTo(camera)
        if root is not None and self._section is None:
            self._section = self._build(root, opened or _first_names(root))
        self._arrange()

    def forget(self, camera: Hashable) -> None:
        """Delete the rows of a camera."""
        section = self._sections.pop(camera, None)
        self.rows.forget(camera)
        if section is None:
            return
        if section is self._section:
            self._section = None
        self.sections.removeWidget(section)
        section.hide()
        section.deleteLater()

    def _build(self, root: Category, opened: Collection[str]) -> Section:
        section = Section(root, self._make_row, self._pacer, frozenset(opened), self.content)
        section.removeHeader()
        section.toggled.connect(self._arrange)
        section.allRequested.connect(self.setAllOpen)
        self.sections.insertWidget(0, section)
        self._sections[self._camera] = section
        return section

    def setAllOpen(self, opened: bool) -> None:
        """Open or close all sections of the shown camera."""
        if self._section is not None:
            self._section.setAllOpen(opened)
            self._arrange()

    def setElsewhere(self, names: frozenset[str]) -> None:
        """Leave these out for beginners: other controls of the window set them."""
        if names != self._elsewhere:
            self._elsewhere = names
            self._arrange()

    def setFeature(self, feature: Feature) -> None:
        """Show a feature wherever it has a row."""
        self.rows.setFeature(feature)

    @property
    def watched(self) -> frozenset[str]:
        """Names of the features that can be seen."""
        return self._watched

    def section(self, name: str) -> Section | None:
        """Return the shown camera's section of a category, once it was made."""
        sections = self._section.findChildren(Section) if self._section is not None else []
        return next((section for section in sections if section.category.name == name), None)

    def _make_row(self, description: FeatureDescription, parent: QWidget, indented: bool) -> FeatureRow:
        return self.rows.make(description, parent, indented=indented)

    def _arrange(self) -> None:
        """Show the features that pass level and filter."""
        root = self._section.category if self._section is not None else None
        for control in (self.filterEdit, self.levelBox):
            set_available(control, None if root is not None else Unavailable.SOURCE)
        watched: frozenset[str] = frozenset()
        hidden = 0
        message = self.tr("The camera's controls appear here once one is connected.")
        if self._section is not None and root is not None:
            text = self.filterEdit.text().strip()
            names = visible_names(root, self._level, text, self._elsewhere)
            everything = len(visible_names(root, Visibility.GURU, text))
            hidden = everything - len(names) if text or not names else 0
            message = self._message(text, len(names)) if names or not hidden else ""
            shown = names[:MOST_FOUND] if text else names
            self._section.arrange(frozenset(shown), bool(text))
            watched = frozenset(self._section.names_on_show())
        self.moreButton.setText(self.tr("Show {0} more (Guru)").format(hidden))
        self.moreButton.setVisible(hidden > 0)
        self.messageLabel.setText(message)
        self.messageLabel.setVisible(bool(message))
        if watched != self._watched:
            self._watched = watched
            self.watchedChanged.emit(watched)

    @property
    def _level(self) -> Visibility:
        return _LEVELS[self.levelBox.currentIndex()]

    def _message(self, text: str, found: int) -> str:
        """Return why not all features that match are shown, or that none does."""
        if text and found > MOST_FOUND:
            return counted(
                found - MOST_FOUND,
                self.tr("1 more matches; type another letter."),
                self.tr("{0} more match; type another letter."),
            )
        return "" if found else self.tr("Nothing matches.")


def _first_names(root: Category) -> list[str]:
    first = next((member for member in root.members if isinstance(member, Category)), root)
    return [description.name for description in first.descriptions()]

"""Rows of features: a name, its editor, its automatic mode; and all rows of a view."""

from __future__ import annotations

import logging
from collections.abc import Hashable
from dataclasses import dataclass, field

from PyQt5.QtCore import QByteArray, QEvent, QMimeData, QObject, QPoint, Qt, pyqtSignal
from PyQt5.QtGui import QContextMenuEvent, QDrag, QDropEvent, QMouseEvent
from PyQt5.QtWidgets import QWIDGETSIZE_MAX, QApplication, QGridLayout, QHBoxLayout, QSizePolicy, QWidget

from grabbergui.core.features import AccessMode, Feature, FeatureDescription, FeatureKind, Representation
from grabbergui.core.sfnc import as_editable
from grabbergui.models.features.feature_text import breakable, tooltip
from grabbergui.models.features.slider_scale import SliderScale
from grabbergui.ui.editors.auto_button import AutoButton
from grabbergui.ui.editors.choice_editor import ChoiceEditor
from grabbergui.ui.editors.feature_editor import (
    CodedNumberEditor,
    CommandEditor,
    FeatureEditor,
    ReadingLabel,
    SwitchEditor,
    TextEditor,
)
from grabbergui.ui.editors.number_editors import NumberEditor, RangeEditor
from grabbergui.ui.shown_text import set_tooltip
from grabbergui.ui.widgets.labels import WrappedLabel

log = logging.getLogger(__name__)

FEATURE_MIME = "application/x-grabbergui-feature"
"""MIME type of a dragged feature; the data is its name in UTF-8."""
_BY_KIND: dict[FeatureKind, type[FeatureEditor]] = {
    FeatureKind.BOOLEAN: SwitchEditor,
    FeatureKind.COMMAND: CommandEditor,
    FeatureKind.ENUMERATION: ChoiceEditor,
    FeatureKind.STRING: TextEditor,
}
_EDITABLE_LATER = (FeatureKind.BOOLEAN, FeatureKind.COMMAND)
"""Features that keep their control while they cannot be used, so that the layout stays."""
FIELD_WIDTH, LEAST_SLIDER, TINY_SLIDER = 104, 52, 30
"Pixels of a number that is beside its slider, of the shortest useful slider, and of one in a tiny window."
CARD_WIDTH = 350
"Pixels for a control without a slider beside others, whose texts may change at any time."
INDENT = 14
"""Pixels by which a feature stands below its selector."""


def dragged_feature(event: QDropEvent) -> str:
    """Return the name of the dragged feature; empty if something else is dragged."""
    data = event.mimeData()
    if data is None or not data.hasFormat(FEATURE_MIME):
        return ""
    return bytes(data.data(FEATURE_MIME)).decode("utf-8", "replace")


class RowDrag:
    """Distinguishes a drag from a click. The row passes on the mouse events that no control handles."""

    def __init__(self, row: QWidget, name: str) -> None:
        self._row = row
        self._name = name
        self._pressed: QPoint | None = None

    def press(self, event: QMouseEvent) -> None:
        """Remember where a button was pressed."""
        self._pressed = event.pos() if event.button() == Qt.MouseButton.LeftButton else None

    def move(self, event: QMouseEvent) -> None:
        """Drag the row once the mouse has moved far enough with a button down."""
        if self._pressed is None:
            return
        if (event.pos() - self._pressed).manhattanLength() >= QApplication.startDragDistance():
            self._pressed = None
            self._drag()

    def _drag(self) -> None:
        data = QMimeData()
        data.setData(FEATURE_MIME, QByteArray(self._name.encode()))
        drag = QDrag(self._row)
        drag.setMimeData(data)
        drag.setPixmap(self._row.grab())
        drag.exec_(Qt.DropAction.CopyAction)


def editor_class(feature: Feature, current: type[FeatureEditor] | None = None) -> type[FeatureEditor]:
    """Return the class of editor for a feature that an editor of class `current`, if any, shows now.

    A read-only feature is a label, unless it had an editor: a control that is locked for a while turns
    grey instead of going away.
    """
    if feature.problem:
        return ReadingLabel
    locked = not feature.access.writable and feature.kind not in _EDITABLE_LATER
    if locked and current in (None, ReadingLabel):
        return ReadingLabel
    if locked and feature.access is not AccessMode.READ_ONLY and current is not None:
        return current
    return _editor_of_kind(feature)


def _editor_of_kind(feature: Feature) -> type[FeatureEditor]:
    if feature.kind in _BY_KIND:
        return _BY_KIND[feature.kind]
    if feature.representation is Representation.BOOLEAN:
        return SwitchEditor
    if feature.coded:
        return CodedNumberEditor
    return NumberEditor if SliderScale.of(feature) is None else RangeEditor


class FeatureRow(QWidget):
    """The name on the left, the editor on the right; a slider is on a line of its own below, or between them.

    Empty until the first `setFeature`; all rows of a width have their columns in the same places.
    """

    edited = pyqtSignal(str, object)
    """Name and value that the user chose, of the feature or of its automatic mode."""
    executed = pyqtSignal(str)
    held = pyqtSignal(str)
    released = pyqtSignal(str)
    explanationRequested = pyqtSignal(str)
    """The mouse is over a feature that cannot be changed, and what hides or locks it is not known yet."""
    menuRequested = pyqtSignal(str, QPoint)
    """The context menu is requested, at a place on the screen."""

    def __init__(
        self, description: FeatureDescription, parent: QWidget | None = None, *, indented: bool = False
    ) -> None:
        super().__init__(parent)
        self.name = description.name
        self.title = description.title
        self.editor: FeatureEditor | None = None
        self.auto: AutoButton | None = None
        self._feature: Feature | None = None
        self._auto_feature: Feature | None = None
        self._lock = ""
        "Why nothing can be changed now."
        self._odd = False
        "Whether the feature cannot be shown."
        self._in_line = False
        "Whether the slider is beside the editor."
        self._label = WrappedLabel(breakable(self.title))
        self._label.setSizePolicy(_column_policy())
        self._label.setCursor(Qt.CursorShape.OpenHandCursor)
        self._drag = RowDrag(self, self.name)
        self._cell = QWidget()
        self._cell.setSizePolicy(_column_policy())
        self._cell_line = QHBoxLayout(self._cell)
        self._slider_line = QHBoxLayout()
        for line in (self._cell_line, self._slider_line):
            line.setContentsMargins(0, 0, 0, 0)
            line.setSpacing(6)
        if indented:  # input fields stay in their column
            self._label.setContentsMargins(INDENT, 0, 0, 0)
            self._slider_line.setContentsMargins(INDENT, 0, 0, 0)
        self._grid = grid = QGridLayout(self)
        grid.setContentsMargins(0, 1, 0, 1)
        grid.setHorizontalSpacing(8)
        grid.setVerticalSpacing(2)
        grid.setColumnStretch(0, 11)
        grid.setColumnStretch(1, 13)
        grid.addWidget(self._label, 0, 0)
        grid.addWidget(self._cell, 0, 1)
        grid.addLayout(self._slider_line, 1, 0, 1, 2)
        self._cell.setMinimumHeight(self.fontMetrics().height() + 8)

    def standBesideOthers(self) -> None:
        """Take one line: name, slider, editor and automatic mode."""
        self._in_line = True
        self._label.setWordWrap(False)
        self._label.setSizePolicy(QSizePolicy.Policy.Maximum, QSizePolicy.Policy.Preferred)
        self._cell.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Preferred)
        self._grid.removeItem(self._slider_line)
        self._grid.addLayout(self._slider_line, 0, 1)
        self._grid.addWidget(self._cell, 0, 2)
        self._grid.setColumnStretch(0, 0)
        self._share_line()

    def _share_line(self) -> None:
        """Give the slider the width that name and editor leave, or the editor if there is none."""
        if self._in_line:
            has_slider = self.editor is not None and self.editor.slider() is not None
            self._grid.setColumnStretch(1, int(has_slider))
            self._grid.setColumnStretch(2, int(not has_slider))
            expected = has_slider or self.editor is None  # so that lines of controls stay when values come
            self._grid.setColumnMinimumWidth(1, TINY_SLIDER if expected else 0)
            self._grid.setColumnMinimumWidth(2, FIELD_WIDTH if expected else 0)
            if self.editor is not None:
                self.editor.setMinimumWidth(FIELD_WIDTH if has_slider else 0)
                self.editor.setMaximumWidth(FIELD_WIDTH if has_slider else QWIDGETSIZE_MAX)

    def leastWidth(self) -> int:
        """Return the pixels that it needs beside others, with a slider that can just be aimed at."""
        has_slider = self.editor is None or self.editor.slider() is not None
        useful = self._grid.minimumSize().width() + LEAST_SLIDER - TINY_SLIDER
        return min(useful, CARD_WIDTH) if has_slider else CARD_WIDTH

    @property
    def autoName(self) -> str | None:
        """Name of the automatic mode's feature, once known."""
        return self._feature.auto if self._feature is not None else None

    def setFeature(self, feature: Feature) -> None:
        """Show a feature. Never emits `edited`; a feature that cannot be shown disables this row only."""
        self._feature = feature
        if feature.auto:
            self._auto_button()  # its place is kept, so that no slider shrinks when the mode is known
        shown = as_editable(feature, self._auto_feature)
        set_tooltip(self, self._lock or tooltip(shown))
        self._odd = False
        try:
            self._show(shown)
        except Exception:
            # One odd node must not take the panel with it.
            log.exception("%s cannot be shown", feature.name)
            self._drop_editor()
            self._odd = True
        self.setEnabled(not (self._odd or self._lock))

    def setLocked(self, reason: str) -> None:
        """Lock the row and show the reason; with an empty reason, unlock it."""
        if reason == self._lock:
            return
        self._lock = reason
        self.setEnabled(not (self._odd or reason))
        if self._feature is not None:
            self.setFeature(self._feature)

    def setAuto(self, feature: Feature) -> None:
        """Show the automatic mode; moving a control that only this mode locks switches it off."""
        self._auto_feature = feature
        self._auto_button().setFeature(feature)
        if self._feature is not None and self._feature.access is AccessMode.READ_ONLY:
            self.setFeature(self._feature)

    def enterEvent(self, event: QEvent | None) -> None:
        """Ask, before the tooltip is shown, for its reason."""
        super().enterEvent(event)
        feature = self._feature
        if feature is None or feature.constant or feature.problem or feature.conditions or self._lock:
            return
        if not as_editable(feature, self._auto_feature).access.writable:
            self.explanationRequested.emit(self.name)

    def mousePressEvent(self, event: QMouseEvent | None) -> None:
        """Remember where a drag may begin."""
        if event is not None:
            self._drag.press(event)

    def mouseMoveEvent(self, event: QMouseEvent | None) -> None:
        """Begin to drag the feature to the favourites."""
        if event is not None:
            self._drag.move(event)

    def contextMenuEvent(self, event: QContextMenuEvent | None) -> None:
        """Request the context menu that all features have."""
        if event is not None:
            self.menuRequested.emit(self.name, event.globalPos())
            event.accept()

    def _show(self, feature: Feature) -> None:
        wanted = editor_class(feature, type(self.editor) if self.editor is not None else None)
        if type(self.editor) is not wanted:
            self._drop_editor()
            self._build_editor(wanted)
        assert self.editor is not None
        self.editor.setFeature(feature)
        usable = feature.access.writable
        self._label.setEnabled(usable or feature.access.readable)
        # Read-only values stay legible and can be copied.
        self.editor.setEnabled(usable or (feature.access.readable and wanted is ReadingLabel))
        if (slider := self.editor.slider()) is not None:
            slider.setEnabled(usable)

    def _build_editor(self, wanted: type[FeatureEditor]) -> None:
        self.editor = editor = wanted()
        editor.valueEdited.connect(self._on_editor_value_edited)
        editor.editingStarted.connect(lambda: self.held.emit(self.name))
        editor.editingFinished.connect(lambda: self.released.emit(self.name))
        self._cell_line.insertWidget(0, editor, 1)
        if (slider := editor.slider()) is not None:
            self._slider_line.insertWidget(0, slider, 1)
        self._share_line()
        self._place_auto()

    def _drop_editor(self) -> None:
        if self.editor is None:
            return
        if (slider := self.editor.slider()) is not None:
            self._slider_line.removeWidget(slider)
            slider.setParent(self.editor)
        self._cell_line.removeWidget(self.editor)
        self.editor.hide()
        self.editor.deleteLater()
        self.editor = None
        self.released.emit(self.name)

    def _auto_button(self) -> AutoButton:
        if self.auto is None:
            self.auto = AutoButton()
            self.auto.modeChosen.connect(lambda mode: self._emit_mode(mode))
            self._place_auto()
        return self.auto

    def _place_auto(self) -> None:
        if self.auto is None:
            return
        below = not self._in_line and self.editor is not None and self.editor.slider() is not None
        (self._slider_line if below else self._cell_line).addWidget(self.auto)

    def _on_editor_value_edited(self, value: object) -> None:
        if self._feature is not None and self._feature.kind is FeatureKind.COMMAND:
            self.executed.emit(self.name)
        else:
            self.edited.emit(self.name, value)

    def _emit_mode(self, mode: object) -> None:
        if self.autoName:
            self.edited.emit(self.autoName, mode)


def _column_policy() -> QSizePolicy:
    """Return the policy of a cell: as wide as its column, and as high as its wrapped lines."""
    policy = QSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
    policy.setHeightForWidth(True)
    return policy


@dataclass
class _Page:
    """The rows of one camera, and their content."""

    features: dict[str, Feature] = field(default_factory=dict)
    rows: dict[str, list[FeatureRow]] = field(default_factory=dict)
    by_auto: dict[str, list[FeatureRow]] = field(default_factory=dict)


class FeatureRows(QObject):
    """Passes features to the rows that show them; a feature may have several rows, or none yet.

    Each camera has a page of its own, so that switching between cameras rebuilds nothing.
    """

    edited = pyqtSignal(str, object)
    executed = pyqtSignal(str)
    held = pyqtSignal(str)
    released = pyqtSignal(str)
    explanationRequested = pyqtSignal(str)
    menuRequested = pyqtSignal(str, QPoint)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._page = _Page()
        self._pages: dict[Hashable, _Page] = {None: self._page}
        self._lock = ""

    def turnTo(self, camera: Hashable) -> None:
        """Use the rows of this camera from now on; None is no camera."""
        self._page = self._pages.setdefault(camera, _Page())
        self.setLocked(self._lock)

    def forget(self, camera: Hashable) -> None:
        """Forget a camera's features and rows; the owner of the rows deletes them."""
        if (page := self._pages.pop(camera, None)) is self._page:
            self.turnTo(camera)
        elif page is not None:
            page.rows.clear()

    def shown(self, name: str) -> Feature | None:
        """Return the feature as the current camera's rows show it; None if they do not."""
        return self._page.features.get(name)

    def make(
        self, description: FeatureDescription, parent: QWidget | None = None, *, indented: bool = False
    ) -> FeatureRow:
        """Make a row on the current camera's page, and fill it if the feature is known."""
        row = FeatureRow(description, parent, indented=indented)
        row.edited.connect(self.edited)
        row.executed.connect(self.executed)
        row.held.connect(self.held)
        row.released.connect(self.released)
        row.explanationRequested.connect(self.explanationRequested)
        row.menuRequested.connect(self.menuRequested)
        row.setLocked(self._lock)
        self._page.rows.setdefault(row.name, []).append(row)
        if (feature := self._page.features.get(row.name)) is not None:
            self._show(row, feature)
        return row

    def rows(self, name: str) -> list[FeatureRow]:
        """Return the rows of a feature."""
        return self._page.rows.get(name, [])

    def setFeature(self, feature: Feature) -> None:
        """Show a feature wherever it has a row, also as the automatic mode of another."""
        self._page.features[feature.name] = feature
        for row in self._page.rows.get(feature.name, ()):
            self._show(row, feature)
        for row in self._page.by_auto.get(feature.name, ()):
            row.setAuto(feature)

    def setLocked(self, reason: str) -> None:
        """Lock every row, also future ones, and show the reason; with an empty reason, unlock them."""
        self._lock = reason
        for rows in self._page.rows.values():
            for row in rows:
                row.setLocked(reason)

    def _show(self, row: FeatureRow, feature: Feature) -> None:
        row.setFeature(feature)
        if not feature.auto:
            return
        listeners = self._page.by_auto.setdefault(feature.auto, [])
        if row not in listeners:
            listeners.append(row)
            if (auto := self._page.features.get(feature.auto)) is not None:
                row.setAuto(auto)

"""Windows: forms, the screen, dialogs for files, and the routing of keys and wheel.

Forms are edited in Qt Designer only; no Python copy of them exists.

Tab follows the reading order, also through controls that were made later. Qt's own order is the order of
creation, and `setTabOrder` does not handle compound widgets.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.machinery import SourceFileLoader
from itertools import groupby
from pathlib import Path
from types import CodeType
from typing import Any

from PyQt5.QtCore import QEvent, QFileInfo, QObject, QPoint, QSize, Qt, pyqtSignal
from PyQt5.QtGui import QGuiApplication, QKeyEvent, QKeySequence
from PyQt5.QtWidgets import (
    QWIDGETSIZE_MAX,
    QAction,
    QApplication,
    QFileDialog,
    QFrame,
    QLabel,
    QScrollArea,
    QWidget,
)

from grabbergui.models.open_source import Lack
from grabbergui.ui.shown_text import add_to_tooltip, make_plain, tooltip_of
from grabbergui.ui.theme import apply_icons

# -- forms ---------------------------------------------------------------------------------------
_FORMS = Path(__file__).with_name("forms")


def load_form(name: str, into: QWidget) -> None:
    """Build the form `ui/forms/<name>.ui` in a widget of the form's own class, with the icons that it names.

    The form's children become attributes of `into`, by their object names. Its labels show plain text.
    """
    form = _form(name)()
    form.setupUi(into)
    for label in into.findChildren(QLabel):
        make_plain(label)
    for child, widget in vars(form).items():
        setattr(into, child, widget)
    apply_icons(into)


def compile_forms() -> None:
    """Compile all forms, after an installation into a folder that its users may not write to."""
    for form in _FORMS.glob("*.ui"):
        _form(form.stem)


@cache
def _form(name: str) -> type[Any]:
    """Return the class that Qt's compiler makes of a form; its `setupUi` fills a widget."""
    code = _FormLoader(name, str(_FORMS / f"{name}.ui")).get_code(name)
    assert code is not None, "get_code answers None only for modules without code"
    made: dict[str, Any] = {}
    exec(code, made)
    compiled: type[Any] = next(value for name, value in made.items() if name.startswith("Ui_"))
    return compiled


class _FormLoader(SourceFileLoader):
    """Compiles a form as Python compiles a module: once, and again after its file has changed.

    Python keeps the code in `forms/__pycache__`, if it may write there. Reading the XML would take half
    of the time to build a window.
    """

    def source_to_code(self, data: Any, path: Any, *, _optimize: int = -1) -> CodeType:  # type: ignore[override]
        """Compile the XML of a form without its list of connections, which is empty.

        Qt would look in every child for signals that match the names of our methods.
        """
        from PyQt5 import uic  # here, because its import takes as long as building a window

        # No form uses Qt's plugin widgets, and for each form all plugins would be searched for and run again.
        uic.widgetPluginPath.clear()
        source = io.StringIO()
        form = io.StringIO(bytes(data).decode().replace("<connections/>", ""))
        uic.compileUi(form, source)  # type: ignore[no-untyped-call]
        return super().source_to_code(source.getvalue().encode(), path)


# -- the screen ----------------------------------------------------------------------------------
TITLE_BAR = 40
"Pixels that a window manager may take of the screen's height for a window's title."


def fit_screen(window: QWidget) -> None:
    """Make a window no larger than the screen, where its last buttons would be out of reach."""
    if has_screen():
        window.resize(window.size().boundedTo(screen_room(window)))


def screen_room(window: QWidget) -> QSize:
    """Return the largest size of a window on its screen, without the title."""
    screen = window.screen()
    if screen is None:
        return QSize(QWIDGETSIZE_MAX, QWIDGETSIZE_MAX)
    return screen.availableGeometry().size() - QSize(0, TITLE_BAR)


def has_screen() -> bool:
    """Return whether windows are seen; Qt's offscreen platform only claims a screen of 800 × 800 pixels."""
    return QGuiApplication.platformName() != "offscreen"


# -- files ---------------------------------------------------------------------------------------
class FileDialogs:
    """Qt's modal dialogs for files. Implements `bases.FileQuestions`.

    They are over the active window, which gets the focus back, or else over the given one.
    """

    def __init__(self, window: QWidget) -> None:
        self._window = window

    @property
    def _parent(self) -> QWidget:
        return QApplication.activeWindow() or self._window

    def to_open(self, title: str, kinds: str, folder: Path | None = None) -> Path | None:
        """Ask for a file that exists; `kinds` is a filter such as `Settings (*.yaml)`."""
        place = str(folder) if folder is not None else ""
        chosen, _ = QFileDialog.getOpenFileName(self._parent, title, place, kinds)
        return Path(chosen) if chosen else None

    def to_save(self, title: str, name: str, kinds: str) -> Path | None:
        """Ask for a file to write; `name` is the suggestion."""
        chosen, _ = QFileDialog.getSaveFileName(self._parent, title, name, kinds)
        return Path(chosen) if chosen else None

    def folder(self, title: str, before: Path) -> Path | None:
        """Ask for a folder; `before` is the one used so far, which need not exist yet."""
        # In place of a folder that does not exist, Qt offers one of its name below the working directory.
        place = next(
            (folder for folder in (before, *before.parents) if QFileInfo(str(folder)).isDir()), Path.home()
        )
        chosen = QFileDialog.getExistingDirectory(self._parent, title, str(place))
        return Path(chosen) if chosen else None


# -- actions -------------------------------------------------------------------------------------
_PURPOSE = "purpose"
"The property of an action or button that keeps the tooltip it has while it is available."


@dataclass(frozen=True)
class _Purpose:
    tooltip: str
    "A `Markup` if it is rich; as a property of its own it would become a plain text."


def set_available(action: QAction | QWidget, lack: Lack | str | None) -> None:
    """Enable an action or a control, or disable it and give the reason, if any, in its tooltip."""
    purpose = action.property(_PURPOSE)
    if purpose is None:
        purpose = _Purpose(tooltip_of(action))
        action.setProperty(_PURPOSE, purpose)
    reason = lack.text if isinstance(lack, Lack) else lack or ""
    action.setEnabled(not reason)
    add_to_tooltip(action, purpose.tooltip, reason)


# -- the Tab key ---------------------------------------------------------------------------------
LINE_HEIGHT = 12
"Pixels of height within which controls stand on one line."


def reading_order(regions: Sequence[QWidget]) -> list[QWidget]:
    """Return the controls that take the Tab key: region by region, in each line by line from the left."""
    return [widget for region in regions if region.isVisible() for widget in _lines(region)]


def give_focus(regions: Sequence[QWidget], at: QWidget | None, *, forward: bool) -> bool:
    """Give the focus to the control after `at`, or before it. Return False if there is none."""
    order = reading_order(regions)
    if not order:
        return False
    known = at
    while known is not None and known not in order:
        known = known.parentWidget()
    step = 1 if forward else -1
    index = (order.index(known) + step) % len(order) if known is not None else 0
    reason = Qt.FocusReason.TabFocusReason if forward else Qt.FocusReason.BacktabFocusReason
    order[index].setFocus(reason)
    _bring_into_view(order[index])
    return True


def _lines(region: QWidget) -> list[QWidget]:
    places = []
    for widget in region.findChildren(QWidget):
        if _takes_tab(widget):
            middle = widget.mapTo(region, QPoint(0, widget.height() // 2))
            places.append((middle.y(), middle.x(), widget))
    places.sort(key=lambda place: place[:2])
    line, last = 0, None
    numbered = []
    for y, x, widget in places:
        if last is not None and y - last >= LINE_HEIGHT:
            line += 1
        if last is None or y - last >= LINE_HEIGHT:
            last = y
        numbered.append((line, x, widget))
    ordered: list[QWidget] = []
    for _, on_line in groupby(numbered, key=lambda place: place[0]):
        ordered += [widget for _, _, widget in sorted(on_line, key=lambda place: place[1])]
    return ordered


def _takes_tab(widget: QWidget) -> bool:
    takes = widget.focusPolicy() & Qt.FocusPolicy.TabFocus and widget.focusProxy() is None
    # A scroll area itself is of no use to the keyboard where its content takes the focus.
    return bool(takes) and widget.isVisible() and widget.isEnabled() and not isinstance(widget, QScrollArea)


def _bring_into_view(widget: QWidget) -> None:
    above = widget.parentWidget()
    while above is not None:
        if isinstance(above, QScrollArea):
            above.ensureWidgetVisible(widget)
        above = above.parentWidget()


# -- other keys, and the wheel -------------------------------------------------------------------
class StopKeys(QObject):
    """Catches its keys in a window and all of its children, before any of these handles them."""

    pressed = pyqtSignal()

    def __init__(self, window: QWidget, keys: Sequence[Qt.Key]) -> None:
        """Watch the window and its present children."""
        super().__init__(window)
        self.keys = tuple(keys)
        """The keys that stop now; may be changed."""
        for watched in (window, *window.findChildren(QWidget)):
            watched.installEventFilter(self)

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Emit for a stop key; a key that is held down counts once."""
        if isinstance(event, QKeyEvent) and event.key() in self.keys:
            if event.type() == QEvent.Type.ShortcutOverride:
                event.accept()
                return True
            if event.type() == QEvent.Type.KeyPress:
                event.accept()
                if not event.isAutoRepeat():
                    self.pressed.emit()
                return True
        return super().eventFilter(watched, event)


class Popup(QFrame):
    """A popup that closes on a shortcut of its window and triggers the action; Qt ignores the key."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent, Qt.WindowType.Popup)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._window = parent.window()

    def event(self, event: QEvent | None) -> bool:
        """Take the keys of application-wide shortcuts, too, so that the popup closes first."""
        if event is not None and event.type() == QEvent.Type.ShortcutOverride:
            event.accept()
            return True
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        """Trigger the action of a shortcut."""
        if event is not None and self._window is not None:
            pressed = QKeySequence(int(event.modifiers()) | event.key())
            for action in self._window.findChildren(QAction):
                everywhere = action.shortcutContext() != Qt.ShortcutContext.WidgetWithChildrenShortcut
                if everywhere and action.isEnabled() and action.shortcut() == pressed:
                    self.close()
                    action.trigger()
                    return
        super().keyPressEvent(event)


class MenuKeys(QObject):
    """Gives an open menu the letters of its mnemonics; shortcuts of the image would take them."""

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Accept a key without Ctrl, so that no shortcut is tried."""
        if not isinstance(event, QKeyEvent) or event.type() != QEvent.Type.ShortcutOverride:
            return False
        if event.modifiers() & Qt.KeyboardModifier.ControlModifier:
            return False
        event.accept()
        return True


class WheelGuard(QObject):
    """Lets the wheel reach its widget only while that has the focus; otherwise the panel scrolls."""

    def __init__(self, widget: QWidget) -> None:
        super().__init__(widget)
        widget.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        widget.installEventFilter(self)

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Ignore a wheel event without focus, so that the parent gets it."""
        if (
            event is not None
            and event.type() == QEvent.Type.Wheel
            and isinstance(watched, QWidget)
            and not watched.hasFocus()
        ):
            event.ignore()
            return True
        return False


_COMMANDING = Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.AltModifier
_UNDO = (QKeySequence.StandardKey.Undo, QKeySequence.StandardKey.Redo)
_EDITING = (
    QKeySequence.StandardKey.Copy,
    QKeySequence.StandardKey.Cut,
    QKeySequence.StandardKey.Paste,
    QKeySequence.StandardKey.SelectAll,
)
_MOVING = (Qt.Key.Key_Left, Qt.Key.Key_Right, Qt.Key.Key_Home, Qt.Key.Key_End, Qt.Key.Key_Up, Qt.Key.Key_Down,
           Qt.Key.Key_Backspace, Qt.Key.Key_Delete)  # fmt: skip


class ShortcutGuard(QObject):
    """Keeps a line edit or spin box from taking the window's keys with Ctrl for itself.

    On X11 such a field clears itself on Ctrl+U and moves its cursor on Ctrl+E, and it takes Ctrl+Z even where
    nothing was typed. Here it keeps what belongs to editing text; undo and redo only while `typing`.
    """

    def __init__(self, field: QWidget, typing: Callable[[], bool]) -> None:
        super().__init__(field)
        self._typing = typing
        field.installEventFilter(self)

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Keep the window's keys from the field, both the shortcut override and the key press.

        The field's own keys are no shortcuts, and are not offered to the widgets around it.
        """
        if not isinstance(event, QKeyEvent):
            return False
        overriding = event.type() == QEvent.Type.ShortcutOverride
        if not event.modifiers() & _COMMANDING:
            if overriding and event.key() in _MOVING:
                event.accept()
                return True
            return False
        if not (overriding or event.type() == QEvent.Type.KeyPress) or not self._belongs_to_window(event):
            return False
        event.ignore()
        return True

    def _belongs_to_window(self, event: QKeyEvent) -> bool:
        if any(event.matches(key) for key in _UNDO):
            return not self._typing()
        if not event.modifiers() & Qt.KeyboardModifier.ControlModifier:
            return False
        return event.key() not in _MOVING and not any(event.matches(key) for key in _EDITING)

"""The controls of a window that a user can operate, and what a screen reader calls them."""

from PyQt5.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSlider,
    QAbstractSpinBox,
    QComboBox,
    QGraphicsView,
    QHeaderView,
    QLabel,
    QLineEdit,
    QPlainTextEdit,
    QScrollBar,
    QTableView,
    QWidget,
)

CONTROLS = (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSlider,
    QAbstractSpinBox,
    QComboBox,
    QGraphicsView,
    QLineEdit,
    QPlainTextEdit,
)
QTS_OWN = ("qt_", "ScrollLeftButton", "ScrollRightButton")
"Beginnings of the names of parts that Qt makes and names itself."


def is_qts_own(widget):
    corner = isinstance(widget, QAbstractButton) and isinstance(widget.parent(), QTableView)
    return widget.objectName().startswith(QTS_OWN) or corner or isinstance(widget, (QScrollBar, QHeaderView))


def controls(window):
    """Return the widgets that a user can operate, at any depth."""
    for widget in window.findChildren(QWidget):
        parts = isinstance(widget.parent(), (QAbstractSpinBox, QComboBox, QLineEdit))
        inner = isinstance(widget.window(), QWidget) and widget.window() is not window
        if isinstance(widget, CONTROLS) and not (parts or inner or is_qts_own(widget)):
            yield widget


def spoken_name(control, window):
    """Return a control's name for screen readers, by Qt's own rules."""
    text = control.text() if isinstance(control, QAbstractButton) else ""
    label = next((label for label in window.findChildren(QLabel) if label.buddy() is control), None)
    return control.accessibleName() or text or (label.text() if label is not None else "")

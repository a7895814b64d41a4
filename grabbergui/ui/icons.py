"""The icons in `resources/icons`, drawn in the colour of the text they stand beside.

Forms name an icon in the dynamic property `iconName`; `load_form` has `apply` give it to actions and buttons.
"""

from __future__ import annotations

from functools import cache, lru_cache
from importlib import resources

from PyQt5.QtCore import QByteArray, QRectF, QSize, Qt
from PyQt5.QtGui import QColor, QIcon, QImage, QPainter, QPalette, QPixmap
from PyQt5.QtSvg import QSvgRenderer
from PyQt5.QtWidgets import QAbstractButton, QAction, QWidget

_SIZES = (16, 20, 24, 32, 40, 48)
_INK = b"currentColor"


@cache
def _drawing(name: str) -> bytes:
    return (resources.files("grabbergui.resources") / "icons" / f"{name}.svg").read_bytes()


def icon(name: str, palette: QPalette) -> QIcon:
    """The icon of a name, in the palette's text colours, sharp on any screen."""
    made = QIcon()
    for mode, group in ((QIcon.Mode.Normal, QPalette.Active), (QIcon.Mode.Disabled, QPalette.Disabled)):
        colour = palette.color(group, QPalette.ButtonText)
        for size in _SIZES:
            made.addPixmap(_drawn(name, colour, size), mode)
    return made


def pixmap(name: str, beside: QWidget, size: int, colour: QColor | None = None) -> QPixmap:
    """One picture of an icon, `size` logical pixels wide, for a label."""
    ratio = beside.devicePixelRatioF()
    drawn = _drawn(name, colour or beside.palette().color(QPalette.WindowText), round(size * ratio))
    drawn.setDevicePixelRatio(ratio)
    return drawn


def dot(colour: QColor) -> QIcon:
    """Return a small disc, for a row of a list."""
    canvas = QPixmap(16, 16)
    canvas.fill(Qt.GlobalColor.transparent)
    painter = QPainter(canvas)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(colour)
    painter.drawEllipse(3, 3, 10, 10)
    painter.end()
    return QIcon(canvas)


def window_icon() -> QIcon:
    """The program's own icon, in its own colours."""
    made = QIcon()
    for size in (16, 24, 32, 48, 64, 128, 256):
        made.addPixmap(_drawn("grabbergui", QColor(Qt.GlobalColor.black), size))
    return made


def apply(root: QWidget) -> None:
    """Give every action and button below `root` the icon its property `iconName` names."""
    for action in root.findChildren(QAction):
        if name := action.property("iconName"):
            action.setIcon(icon(name, root.palette()))
    for button in root.findChildren(QAbstractButton):
        if name := button.property("iconName"):
            button.setIcon(icon(name, root.palette()))
            button.setIconSize(QSize(18, 18))


def _drawn(name: str, colour: QColor, size: int) -> QPixmap:
    return QPixmap.fromImage(_image(name, colour.name(), size))


@lru_cache(maxsize=1024)
def _image(name: str, colour: str, size: int) -> QImage:
    """Draw an icon; kept, because windows and dialogs show the same few icons in the same few colours."""
    drawing = _drawing(name).replace(_INK, colour.encode())
    canvas = QImage(size, size, QImage.Format.Format_ARGB32_Premultiplied)
    canvas.fill(Qt.GlobalColor.transparent)
    painter = QPainter(canvas)
    QSvgRenderer(QByteArray(drawing)).render(painter, QRectF(0, 0, size, size))
    painter.end()
    return canvas

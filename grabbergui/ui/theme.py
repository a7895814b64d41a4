"""Light and dark themes, the desktop's by default; icons in the colour of the text beside them.

The icons are those of `resources/icons`. Forms name one in the dynamic property `iconName`; `load_form` has
`apply_icons` give it to actions and buttons.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from functools import cache, lru_cache
from importlib import resources
from string import Template

from PyQt5.QtCore import QByteArray, QRect, QRectF, QSize, Qt
from PyQt5.QtDBus import QDBus, QDBusConnection, QDBusInterface
from PyQt5.QtGui import QColor, QFont, QIcon, QIconEngine, QImage, QPainter, QPalette, QPixmap
from PyQt5.QtSvg import QSvgRenderer
from PyQt5.QtWidgets import QAbstractButton, QAction, QApplication, QWidget

OFFSCREEN_POINTS = 10
"Size of text where no desktop says one: Qt's own is made for larger screens."
PORTAL_PATIENCE_MS = 150
"How long the desktop may take to say which look it has."
_INK = b"currentColor"


class Theme(Enum):
    """The choice of a theme."""

    AUTO = "auto"
    "As the desktop."
    LIGHT = "light"
    DARK = "dark"


@dataclass(frozen=True)
class Colours:
    """The colours of a theme; style.qss uses the same names."""

    window: str
    panel: str
    "Background of editors, lists and text fields."
    raised: str
    "Buttons, headers."
    hover: str
    "Buttons and rows under the mouse."
    line: str
    "Dividers."
    edge: str
    "Around fields and buttons: seen against `window`, `panel` and `raised`."
    knob: str
    "The handle of a slider."
    text: str
    muted: str
    "Text of less importance; at least 4.5:1 on `window`."
    faint: str
    "Disabled text."
    accent: str
    accent_hover: str
    on_accent: str
    progress: str
    "A progress bar, below text in `text`."
    canvas: str
    "Around the image: neutral, so that it does not change how colours are seen."
    good: str
    busy: str
    bad: str
    busy_back: str
    bad_back: str
    info_back: str


LIGHT = Colours(
    window="#f3f5f7",
    panel="#ffffff",
    raised="#fbfcfd",
    hover="#e3e9ef",
    line="#d3dae1",
    edge="#a9b4bf",
    knob="#ffffff",
    text="#17212b",
    muted="#566472",
    faint="#9aa6b1",
    accent="#0b6bcb",
    accent_hover="#2a80d6",
    on_accent="#ffffff",
    progress="#8dc1f3",
    canvas="#2a2d31",
    good="#137a3e",
    busy="#8f5a00",
    bad="#b3261e",
    busy_back="#fdf0d5",
    bad_back="#fbe4e2",
    info_back="#e2effc",
)

DARK = Colours(
    window="#1e2226",
    panel="#16191c",
    raised="#2b3036",
    hover="#3a4149",
    line="#3b424a",
    edge="#56606b",
    knob="#dfe5ea",
    text="#e4e8ec",
    muted="#9fabb7",
    faint="#66717c",
    accent="#4aa3ff",
    accent_hover="#74b8ff",
    on_accent="#07182a",
    progress="#1f5c98",
    canvas="#101214",
    good="#5ccf8a",
    busy="#f0b253",
    bad="#ff8a80",
    busy_back="#403218",
    bad_back="#45211f",
    info_back="#1b3450",
)


def dress(app: QApplication, theme: Theme = Theme.AUTO) -> Colours:
    """Apply a theme to the application, also while it runs; return the colours used."""
    if theme is Theme.AUTO:
        theme = Theme.DARK if desktop_is_dark(app) else Theme.LIGHT
    colours = DARK if theme is Theme.DARK else LIGHT
    app.setStyle("Fusion")
    if app.platformName() == "offscreen":
        app.setFont(QFont(app.font().family(), OFFSCREEN_POINTS))
    app.setPalette(palette(colours))
    folder = resources.files("grabbergui.resources")
    style = Template((folder / "style.qss").read_text(encoding="utf-8"))
    look = "dark" if colours is DARK else "light"
    app.setStyleSheet(style.substitute(vars(colours), controls=folder / "controls", look=look))
    for window in app.topLevelWidgets():
        apply_icons(window)
    return colours


def desktop_is_dark(app: QApplication) -> bool:
    """Return the desktop's preference: from its settings portal, or else from the palette it gave to Qt."""
    if app.platformName() not in ("offscreen", "minimal"):
        preference = _portal_preference()
        if preference:
            return preference == 1
    given = app.property("desktopPalette") or app.palette()
    if app.property("desktopPalette") is None:
        app.setProperty("desktopPalette", given)  # before our own palette replaces it
    return bool(QPalette(given).color(QPalette.Window).lightness() < 128)


def _portal_preference() -> int:
    """Return 1 for dark, 2 for light, 0 for none or unknown (org.freedesktop.appearance, color-scheme)."""
    bus = QDBusConnection.sessionBus()
    if not bus.isConnected():
        return 0
    portal = QDBusInterface(
        "org.freedesktop.portal.Desktop",
        "/org/freedesktop/portal/desktop",
        "org.freedesktop.portal.Settings",
        bus,
    )
    portal.setTimeout(PORTAL_PATIENCE_MS)
    answer = portal.call(
        QDBus.CallMode.Block, "Read", "org.freedesktop.appearance", "color-scheme"
    ).arguments()
    value = answer[0] if answer else 0
    while hasattr(value, "variant"):
        value = value.variant()
    return value if isinstance(value, int) else 0


def palette(colours: Colours) -> QPalette:
    """Return the colours as Qt's roles, for everything that the style draws."""
    made = QPalette()
    roles = {
        QPalette.Window: colours.window,
        QPalette.WindowText: colours.text,
        QPalette.Base: colours.panel,
        QPalette.AlternateBase: colours.hover,
        QPalette.Text: colours.text,
        QPalette.Button: colours.raised,
        QPalette.ButtonText: colours.text,
        QPalette.BrightText: colours.bad,
        QPalette.ToolTipBase: colours.raised,
        QPalette.ToolTipText: colours.text,
        QPalette.Highlight: colours.accent,
        QPalette.HighlightedText: colours.on_accent,
        QPalette.Link: colours.accent,
        QPalette.LinkVisited: colours.accent,
        QPalette.PlaceholderText: colours.muted,
        QPalette.Mid: colours.line,
        QPalette.Midlight: colours.line,
    }
    for role, colour in roles.items():
        made.setColor(role, QColor(colour))
    for role in (QPalette.WindowText, QPalette.Text, QPalette.ButtonText, QPalette.PlaceholderText):
        made.setColor(QPalette.Disabled, role, QColor(colours.faint))
    made.setColor(QPalette.Disabled, QPalette.Highlight, QColor(colours.line))
    made.setColor(QPalette.Disabled, QPalette.HighlightedText, QColor(colours.faint))
    return made


@cache
def _drawing(name: str) -> bytes:
    return (resources.files("grabbergui.resources") / "icons" / f"{name}.svg").read_bytes()


def icon(name: str, palette: QPalette) -> QIcon:
    """Return an icon in the palette's text colours. Raises OSError for an unknown name."""
    _drawing(name)  # an exception while Qt paints would end the program
    enabled = palette.color(QPalette.Active, QPalette.ButtonText)
    return QIcon(_IconEngine(name, enabled, palette.color(QPalette.Disabled, QPalette.ButtonText)))


class _IconEngine(QIconEngine):
    """Draws an icon when it is shown, in the size that it is shown in.

    To draw all icons in all sizes took half of the time in which the window is built.
    """

    def __init__(self, name: str, enabled: QColor, disabled: QColor) -> None:
        super().__init__()
        self._name, self._enabled, self._disabled = name, enabled, disabled

    def pixmap(self, size: QSize, mode: QIcon.Mode, state: QIcon.State) -> QPixmap:
        """Return the icon in this many physical pixels; all icons are square."""
        colour = self._disabled if mode == QIcon.Mode.Disabled else self._enabled
        return _drawn(self._name, colour, min(size.width(), size.height()))

    def paint(self, painter: QPainter | None, rect: QRect, mode: QIcon.Mode, state: QIcon.State) -> None:
        """Draw the icon into `rect`, in logical pixels."""
        if painter is not None and (device := painter.device()) is not None:
            drawn = self.pixmap(rect.size() * device.devicePixelRatioF(), mode, state)
            painter.drawPixmap(rect, drawn)

    def clone(self) -> QIconEngine:
        """Return another one, for a copy of the icon that is changed."""
        return _IconEngine(self._name, self._enabled, self._disabled)


def icon_pixmap(name: str, beside: QWidget, size: int) -> QPixmap:
    """Return a pixmap of an icon, `size` logical pixels wide, for a label."""
    ratio = beside.devicePixelRatioF()
    drawn = _drawn(name, beside.palette().color(QPalette.WindowText), round(size * ratio))
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
    """Return the program's icon, in its own colours."""
    made = QIcon()
    for size in (16, 24, 32, 48, 64, 128, 256):
        made.addPixmap(_drawn("grabbergui", QColor(Qt.GlobalColor.black), size))
    return made


def apply_icons(root: QWidget) -> None:
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

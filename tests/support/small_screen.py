"""Shows a dialog on a screen of 800 × 600 pixels, and looks for buttons that are cut off."""

from types import SimpleNamespace

from PyQt5.QtCore import QRect, QSize
from PyQt5.QtWidgets import QAbstractButton, QApplication, QScrollArea

from grabbergui.ui import screen

SCREEN = QRect(0, 0, 800, 600)
ROOM = QSize(800, 560)
"Pixels of that screen without the title of a window."


def out_of_sight(dialog):
    """Buttons that are cut off, and that no scroll bar brings to sight."""
    buttons = [each for each in dialog.findChildren(QAbstractButton) if each.isVisible()]
    return [
        button.objectName() or button.text()
        for button in buttons
        if not any(area.isAncestorOf(button) for area in dialog.findChildren(QScrollArea))
        and (
            button.visibleRegion().boundingRect() != button.rect()
            or button.width() < button.minimumSizeHint().width()
            or button.height() < button.minimumSizeHint().height()
        )
    ]


def check_fits(kind, make, monkeypatch):
    """Fail unless a dialog of this class fits at first, and when it is as large as the screen."""
    small = SimpleNamespace(availableGeometry=lambda: SCREEN, availableSize=SCREEN.size)
    monkeypatch.setattr(screen, "has_screen", lambda: True)
    monkeypatch.setattr(kind, "screen", lambda _: small, raising=False)
    dialog = make()
    dialog.show()
    QApplication.processEvents()
    size = dialog.size()
    assert size == size.boundedTo(ROOM), "as it is at first"
    assert not out_of_sight(dialog)
    dialog.resize(ROOM)
    QApplication.processEvents()
    assert dialog.size() == ROOM, "it may be made as large as the screen"
    assert not out_of_sight(dialog)
    dialog.close()

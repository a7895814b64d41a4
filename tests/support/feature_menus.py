"""The menu of a feature, as a person opens it and chooses from it."""

from PyQt5.QtCore import Qt
from PyQt5.QtGui import QContextMenuEvent
from PyQt5.QtWidgets import QApplication


def menu_of(app, widget):
    """The menu that a click with the right button on a row or its label opens."""
    where = widget.rect().center()
    event = QContextMenuEvent(QContextMenuEvent.Mouse, where, widget.mapToGlobal(where))
    QApplication.sendEvent(widget, event)
    menu = app.program.feature_controls.feature_menu.menu
    app.until(menu.isVisible)
    return menu


def choose_from_menu(app, widget, text):
    """Choose what is called so, and wait until the menu is gone."""
    menu = menu_of(app, widget)
    (action,) = (a for a in menu.actions() if a.text().replace("&", "") == text)
    app.qtbot.mouseClick(menu, Qt.LeftButton, pos=menu.actionGeometry(action).center())
    app.until(lambda: app.program.feature_controls.feature_menu.menu is None)

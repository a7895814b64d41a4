"""The menu of a feature, as a person opens it and chooses from it."""

from PyQt5.QtCore import Qt
from PyQt5.QtGui import QContextMenuEvent
from PyQt5.QtWidgets import QApplication


def menu_of(desk, widget):
    """The menu that a click with the right button on a row or its label opens."""
    where = widget.rect().center()
    event = QContextMenuEvent(QContextMenuEvent.Mouse, where, widget.mapToGlobal(where))
    QApplication.sendEvent(widget, event)
    menu = desk.program.feature_menu.menu
    desk.until(menu.isVisible)
    return menu


def choose_from_menu(desk, widget, text):
    """Choose what is called so, and wait until the menu is gone."""
    menu = menu_of(desk, widget)
    (action,) = (a for a in menu.actions() if a.text().replace("&", "") == text)
    desk.qtbot.mouseClick(menu, Qt.LeftButton, pos=menu.actionGeometry(action).center())
    desk.until(lambda: desk.program.feature_menu.menu is None)

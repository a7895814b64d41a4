"""Full screen: the image alone; the pinned controls are over it while the mouse moves."""

from __future__ import annotations

from collections.abc import Sequence

from PyQt5.QtCore import QEvent, QObject, QPropertyAnimation, Qt, QTimer
from PyQt5.QtWidgets import (
    QAction,
    QApplication,
    QBoxLayout,
    QGraphicsOpacityEffect,
    QMainWindow,
    QShortcut,
    QWidget,
)

from grabbergui.ui.views.image_view import ImageView

STAY_MS = 2500
"Milliseconds for which the controls stay after the last movement of the mouse."
FADE_MS = 400
"Milliseconds in which they fade."
_USES = (QEvent.Type.MouseMove, QEvent.Type.Wheel, QEvent.Type.KeyPress)
"Events that show the controls."


class FullScreen(QObject):
    """Shows the image alone on the whole screen, and everything as it was, maximised too, after Escape."""

    def __init__(
        self,
        window: QMainWindow,
        image: ImageView,
        controls: QWidget,
        around: Sequence[QWidget],
        leave: QAction,
    ) -> None:
        """`controls` are above the image, `around` is all else; `leave` is unchecked by Escape."""
        super().__init__(window)
        self._window, self._image, self._controls, self._around = window, image, controls, tuple(around)
        self._hidden: list[QWidget] = []
        self._in_front: list[QWidget] = []
        "Hidden panels that were seen before: one of several tabs."
        self._shortcuts: list[QAction] = []
        self._maximised = self._active = False
        self._escape = QShortcut(Qt.Key.Key_Escape, image)
        self._escape.setContext(Qt.ShortcutContext.WidgetWithChildrenShortcut)
        self._escape.setEnabled(False)
        self._escape.activated.connect(lambda: leave.setChecked(False))
        self._staying = QTimer(self)
        self._staying.setSingleShot(True)
        self._staying.setInterval(STAY_MS)
        self._staying.timeout.connect(self._fade)
        self._fading: QPropertyAnimation | None = None

    @property
    def active(self) -> bool:
        """Whether the image is alone."""
        return self._active

    def enter(self) -> None:
        """Hide everything but the image, and fill the screen with it."""
        window = self._window
        self._active, self._maximised = True, window.isMaximized()
        self._hidden = [part for part in self._around if not part.isHidden()]
        self._in_front = [part for part in self._hidden if not part.visibleRegion().isEmpty()]
        # Qt ignores the shortcuts of a menu bar that is hidden.
        local = Qt.ShortcutContext.WidgetWithChildrenShortcut
        self._shortcuts = [each for each in window.findChildren(QAction)
                           if not each.shortcut().isEmpty() and each.shortcutContext() != local]  # fmt: skip
        window.addActions(self._shortcuts)
        for part in self._hidden:
            part.hide()
        if (layout := self._layout()) is not None:
            layout.removeWidget(self._controls)
        self._controls.setAutoFillBackground(True)
        self._controls.hide()
        self._escape.setEnabled(True)
        app = QApplication.instance()
        assert app is not None
        app.installEventFilter(self)
        window.showFullScreen()
        self._image.canvas.setFocus(Qt.FocusReason.OtherFocusReason)

    def leave(self) -> None:
        """Show everything as before."""
        app = QApplication.instance()
        assert app is not None
        app.removeEventFilter(self)
        self._escape.setEnabled(False)
        self._staying.stop()
        self._appear()
        if (layout := self._layout()) is not None:
            layout.insertWidget(0, self._controls)
        for part in (*self._hidden, *self._in_front):
            part.show()
            part.raise_()
        for action in self._shortcuts:
            self._window.removeAction(action)
        self._active = False
        if self._maximised:
            self._window.showMaximized()
        else:
            self._window.showNormal()

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Show the controls while the mouse moves in the window, or a key is used."""
        here = isinstance(watched, QWidget) and watched.window() is self._window
        if here and event is not None and event.type() in _USES:
            self._appear()
            self._staying.start()
        return False

    def _appear(self) -> None:
        self._fading = None
        self._controls.setGraphicsEffect(None)
        above = self._controls.parentWidget()
        if above is not None:
            # Controls that wrap are as high as their width makes them.
            self._controls.resize(above.width(), self._controls.height())
            height = max(
                self._controls.heightForWidth(above.width()), self._controls.minimumSizeHint().height()
            )
            self._controls.setGeometry(0, 0, above.width(), height)
        self._controls.show()
        self._controls.raise_()

    def _fade(self) -> None:
        """Let the controls vanish, unless they are in use."""
        focused = QApplication.focusWidget()
        if self._controls.underMouse() or (focused is not None and self._controls.isAncestorOf(focused)):
            self._staying.start()
            return
        effect = QGraphicsOpacityEffect(self._controls)
        self._controls.setGraphicsEffect(effect)
        self._fading = QPropertyAnimation(effect, b"opacity", effect)
        self._fading.setDuration(FADE_MS)
        self._fading.setStartValue(1.0)
        self._fading.setEndValue(0.0)
        self._fading.finished.connect(self._controls.hide)
        self._fading.start()

    def _layout(self) -> QBoxLayout | None:
        above = self._controls.parentWidget()
        layout = above.layout() if above is not None else None
        return layout if isinstance(layout, QBoxLayout) else None

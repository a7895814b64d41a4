"""Opens the point cloud and keeps it of now."""

from __future__ import annotations

from PyQt5.QtCore import QObject
from PyQt5.QtWidgets import QAction, QWidget

from grabbergui.models.picture.picture import PictureModel
from grabbergui.models.picture.points import PointCloudModel
from grabbergui.ui.bridge import Bridge
from grabbergui.ui.views.point_cloud import PointCloudDialog


class PointCloudController(QObject):
    """Draws the points of the newest frame while their window is open. Nothing here changes the camera."""

    def __init__(self, action: QAction, window: QWidget, picture: PictureModel, parent: QObject) -> None:
        super().__init__(parent)
        self._window = window
        self.model = PointCloudModel(lambda: picture.frame, lambda: picture.settings.scan)
        self.dialog: PointCloudDialog | None = None
        action.triggered.connect(self.show)
        bridge = Bridge(self)
        bridge.bind(self.model.ready, self._on_ready)
        bridge.bind(self.model.failed, self._on_failed)

    def show(self) -> None:
        """Open the window, or bring it to the front."""
        if self.dialog is None:
            self.dialog = PointCloudDialog(self._window)
            view = self.dialog.view
            view.turned.connect(self.model.turn)
            view.zoomed.connect(self.model.zoom)
            view.resized.connect(self.model.resize)
            self.dialog.hidden.connect(self._on_hidden)
        self.dialog.show()
        self.dialog.raise_()
        size, ratio = self.dialog.view.size(), self.dialog.view.devicePixelRatioF()
        self.model.start((round(size.width() * ratio), round(size.height() * ratio)))

    def shut_down(self, timeout: float) -> bool:
        """Close the window. Whether drawing ended within `timeout` seconds."""
        if self.dialog is not None:
            self.dialog.close()
        return self.model.stop(timeout)

    def _on_ready(self) -> None:
        if self.dialog is not None and self.model.image is not None:
            self.dialog.view.setImage(self.model.image)

    def _on_failed(self, text: str) -> None:
        if self.dialog is not None:
            self.dialog.view.setProblem(text)

    def _on_hidden(self) -> None:
        self.model.stop()

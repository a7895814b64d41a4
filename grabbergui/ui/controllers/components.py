"""The choice of a component, what of a polarised mosaic is shown, and the window of the point cloud."""

from __future__ import annotations

from dataclasses import replace

from PyQt5.QtCore import QObject
from PyQt5.QtWidgets import QAction, QWidget

from grabbergui.core.scan3d import Scan3d
from grabbergui.models.connection import Connection
from grabbergui.models.open_source import OpenSource
from grabbergui.models.picture.components import CoordinateWatch, PolarisationWatch
from grabbergui.models.picture.picture import PictureModel
from grabbergui.models.picture.points import PointCloudModel
from grabbergui.models.picture.quantities import PolarisedView
from grabbergui.ui.bridge import Bridge
from grabbergui.ui.views.bases import ComponentActions, ComponentView
from grabbergui.ui.views.measuring_panels import HistogramPanel
from grabbergui.ui.views.point_cloud import PointCloudDialog


class ComponentController(QObject):
    """Shows one component of a frame or all, distances by the camera's scale. Never changes the camera."""

    def __init__(
        self,
        actions: ComponentActions,
        view: ComponentView,
        histogram: HistogramPanel,
        connection: Connection,
        picture: PictureModel,
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self._actions = actions
        self._histogram = histogram
        self._picture = picture
        self._coordinates = CoordinateWatch(connection)
        view.componentChosen.connect(self._on_component_chosen)
        view.sideBySideToggled.connect(self._on_side_by_side_toggled)
        actions.polarisedViewChosen.connect(self._on_polarised_view_chosen)
        bridge = Bridge(self)
        self._polarisation = PolarisationWatch(connection)
        actions.actionPolarised.toggled.connect(self._on_polarised_toggled)
        bridge.bind(self._polarisation.found, self._actions.setPolarised)
        bridge.bind(self._coordinates.changed, self._on_coordinates_changed)
        bridge.bind(connection.opened, self._on_connection_opened)

    def _on_component_chosen(self, label: str) -> None:
        # Levels and colours of one component mean nothing in another: each keeps its own.
        before, latest = self._picture.settings, self._picture.latest
        shown = before.component or (latest.label if latest is not None else "")
        if label == shown:
            return
        settings = before.choosing(label, shown)
        self._picture.settings = settings
        self._histogram.setLevels(settings.levels.black, settings.levels.white)
        self._actions.setColourMap(settings.colour_map)
        self._actions.setPolarisedView(settings.polarised)

    def _on_side_by_side_toggled(self, wanted: bool) -> None:
        self._picture.settings = replace(self._picture.settings, side_by_side=wanted)

    def _on_polarised_view_chosen(self, view: PolarisedView) -> None:
        self._picture.settings = replace(self._picture.settings, polarised=view)

    def _on_polarised_toggled(self, polarised: bool) -> None:
        if not polarised and self._picture.settings.polarised is not PolarisedView.MOSAIC:
            self._on_polarised_view_chosen(PolarisedView.MOSAIC)
            self._actions.setPolarisedView(PolarisedView.MOSAIC)

    def _on_coordinates_changed(self, scan: Scan3d) -> None:
        self._picture.settings = replace(self._picture.settings, scan=scan)

    def _on_connection_opened(self, _: OpenSource) -> None:
        before = self._picture.settings
        if before.component or before.appearances or before.polarised is not PolarisedView.MOSAIC:
            mosaic = PolarisedView.MOSAIC
            self._picture.settings = replace(before, component="", appearances={}, polarised=mosaic)
        self._actions.setPolarisedView(PolarisedView.MOSAIC)


class PointCloudController(QObject):
    """Draws the points of the newest frame while their window is open. Never changes the camera."""

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

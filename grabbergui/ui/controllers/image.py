"""The live image: acquisition, display settings, the component shown, and the window of the point cloud."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from PyQt5.QtCore import QObject, QPointF, QTimer, pyqtSignal
from PyQt5.QtWidgets import QAction

from grabbergui.core.coord3d import Scan3d
from grabbergui.core.point_cloud import range_image
from grabbergui.core.scan3d import may_change, read_scan3d
from grabbergui.models.image.camera_watch import CameraWatch, is_polarised
from grabbergui.models.image.components import ShownImage
from grabbergui.models.image.display_settings import with_levels
from grabbergui.models.image.orientation import Orientation
from grabbergui.models.image.pixel_text import beside_text, cursor_text, value_at_text, value_texts
from grabbergui.models.image.points import PointCloudModel
from grabbergui.models.image.quantities import Levels, PolarisedView
from grabbergui.models.open_source import LinkState, OpenSource
from grabbergui.models.sources import GalleryModel
from grabbergui.models.stream_control import StreamControl
from grabbergui.models.unavailable import Unavailable, why_unavailable
from grabbergui.recording.snapshot import SnapshotWriter
from grabbergui.ui.actions import set_available
from grabbergui.ui.controllers.source_context import SourceContext
from grabbergui.ui.gui_thread import Bridge
from grabbergui.ui.views.bases import (
    AcquisitionActions,
    ComponentActions,
    ComponentView,
    DisplayActions,
    DrawableView,
    ReadoutImageView,
)
from grabbergui.ui.views.image_view import PointCloudDialog
from grabbergui.ui.views.measuring_panels import HistogramPanel
from grabbergui.ui.widgets.image_overlays import LEGIBLE_ZOOM, PixelTexts

CURSOR_INTERVAL_MS = 200
"Milliseconds between two readings of the pixel under the cursor."


class AcquisitionController(QObject):
    """Shows the live image; starts, stops, takes snapshots."""

    def __init__(
        self,
        actions: AcquisitionActions,
        view: ReadoutImageView,
        context: SourceContext,
        stream: StreamControl,
        gallery: GalleryModel,
        snapshots: SnapshotWriter,
    ) -> None:
        super().__init__(context.window)
        self._actions = actions
        self._view = view
        self._messages = context.messages
        self._open_sources = context.open_sources
        self._stream = stream
        self._gallery = gallery
        self._image = context.image
        self._snapshots = snapshots
        self._preferences = context.preferences
        self._shown: OpenSource | None = None
        self._bind_models()
        self._bind_view()
        self._timer = QTimer(self)
        self._timer.setInterval(CURSOR_INTERVAL_MS)
        self._timer.timeout.connect(self._on_timer_timeout)
        self._timer.start()
        self._enable_actions()

    def _bind_models(self) -> None:
        bridge = Bridge(self)
        bridge.bind(self._image.ready, self._on_image_ready)
        bridge.bind(self._open_sources.opened, self._on_source_opened)
        bridge.bind(self._open_sources.state_changed, self._on_source_state_changed)
        bridge.bind(self._snapshots.saved, self._on_snapshot_saved)
        bridge.bind(self._snapshots.failed, self._messages.error)
        # Not over the bridge: the queue must be closed before the grabber.
        self._open_sources.closing.connect(self._on_source_closing, check_nargs=False)
        self._bridge = bridge

    def _bind_view(self) -> None:
        actions, view = self._actions, self._view
        actions.actionStart.triggered.connect(self._stream.start)
        actions.actionStop.triggered.connect(self._stream.stop)
        actions.actionSnapshot.triggered.connect(self.snapshot)
        actions.actionPointCloud.triggered.connect(self.save_points)
        view.viewChanged.connect(self._image.set_viewport)
        view.cursorMoved.connect(self._show_cursor)
        view.cursorLeft.connect(self._show_cursor)
        view.painted.connect(self._image.painted)

    def snapshot(self) -> None:
        """Save the newest frame in the snapshot folder."""
        frame, source = self._image.frame, self._open_sources.current
        if frame is None or source is None or source.grabber is None:
            self._messages.error(self.tr("there is no frame to save yet; start the camera first"))
            return
        preferences = self._preferences
        folder, kind = preferences.snapshot_folder, preferences.snapshot_kind
        self._snapshots.save(frame, folder, source.grabber.info, kind)

    def save_points(self) -> None:
        """Save the points of the newest frame in the snapshot folder."""
        frame, source = self._image.frame, self._open_sources.current
        if frame is not None and source is not None and source.grabber is not None:
            folder, scan = self._preferences.snapshot_folder, self._image.settings.scan
            self._snapshots.save_points(frame, folder, source.grabber.info, scan)

    def _on_timer_timeout(self) -> None:
        self._on_image_ready()  # perhaps one that was left while the window was minimised
        self._show_cursor()

    def _on_image_ready(self) -> None:
        if self._view.minimised:
            return  # while an image waits, few frames are converted
        shown = self._image.take()
        if shown is None or self._shown is None:
            return
        self._view.setImage(shown.image, shown.width, shown.height)
        self._view.setComponents(shown.labels, shown.label)
        self._view.setScale(None if shown.quantity is None else shown.quantity.scale)
        self._view.setBeside(shown.others)
        self._show_values(shown)
        self._enable_saving()

    def _show_values(self, shown: ShownImage) -> None:
        """Show the sensor's values on pixels that are large enough."""
        canvas, texts = self._view.canvas, PixelTexts()
        if canvas.zoom >= LEGIBLE_ZOOM * canvas.devicePixelRatioF():
            texts = value_texts(shown, self._image.settings)
        canvas.values.setTexts(texts)

    def _show_cursor(self, *_: int) -> None:
        shown, pixel = self._image.latest, self._view.canvas.cursorPixel
        if shown is None or pixel is None or self._shown is None:
            self._view.setCursorText(())
            return
        settings = self._image.settings
        texts = {other.label: beside_text(shown, other, pixel, settings) for other in shown.others}
        if texts:
            texts[shown.label] = value_at_text(shown, pixel, settings)
        self._view.setCursorText(cursor_text(shown, pixel, settings), texts)

    def _on_source_opened(self, source: OpenSource) -> None:
        if source is not self._open_sources.current or source.grabber is None:
            return
        self._shown = source
        # A source that is lost or waits for a trigger sends nothing now, but its tile has its last image.
        self._image.attach(source.grabber, self._gallery.image_of(source))
        self._enable_actions()

    def _on_source_closing(self, _: OpenSource) -> None:
        self._image.detach()

    def _on_source_state_changed(self, state: LinkState, _: str) -> None:
        if state in (LinkState.CLOSED, LinkState.OPENING):
            self._shown = None
            self._view.clear()
        if state is LinkState.STREAMING:
            self._image.restarted()
        self._enable_actions()

    def _on_snapshot_saved(self, path: Path) -> None:
        self._messages.notice(self.tr("Saved {0}").format(path))

    def _enable_actions(self) -> None:
        state, actions, source = self._open_sources.state, self._actions, self._open_sources.current
        set_available(actions.actionDisconnect, None if source is not None else Unavailable.SOURCE)
        start: Unavailable | str | None = (
            Unavailable.REST if state is LinkState.STREAMING else why_unavailable(source)
        )
        if start is None and source is not None:
            start = source.no_frames  # while another program has control, which has refused it
        set_available(actions.actionStart, start)
        reason = why_unavailable(source, stream=True)
        set_available(actions.actionStop, Unavailable.RUN if reason is Unavailable.STREAM else reason)
        self._enable_saving()

    def _enable_saving(self) -> None:
        frame = self._image.frame if self._shown is not None else None
        no_frame = Unavailable.FRAME if frame is None else None
        no_range = Unavailable.RANGE if frame is not None and range_image(frame) is None else no_frame
        set_available(self._actions.actionSnapshot, no_frame)
        set_available(self._actions.actionPointCloud, no_range)


class DisplayController(QObject):
    """How the image is displayed. Never changes the camera or saved frames."""

    orientationChanged = pyqtSignal()

    def __init__(
        self,
        actions: DisplayActions,
        view: DrawableView,
        histogram: HistogramPanel,
        context: SourceContext,
    ) -> None:
        super().__init__(context.window)
        self._histogram = histogram
        self._image = context.image
        self._canvas = view.canvas
        marks = view.canvas.marks
        Bridge(self).bind(context.open_sources.opened, self._on_source_opened)
        actions.actionCrosshair.toggled.connect(marks.setCrosshair)
        actions.actionGrid.toggled.connect(marks.setGrid)
        actions.actionClipping.toggled.connect(self._on_clipping_toggled)
        actions.colourMapChosen.connect(self._on_colour_map_chosen)
        histogram.levelsDragged.connect(self._on_levels_dragged)
        histogram.levelsReset.connect(self._reset_levels)
        for action, change in (
            (actions.actionTurnRight, lambda seen: seen.turned(1)),
            (actions.actionTurnLeft, lambda seen: seen.turned(-1)),
            (actions.actionMirrorX, lambda seen: seen.mirrored(x=True)),
            (actions.actionMirrorY, lambda seen: seen.mirrored(y=True)),
            (actions.actionUpright, lambda _: Orientation()),
        ):
            action.triggered.connect(lambda _, change=change: self._turn(change))

    def _turn(self, change: Callable[[Orientation], Orientation]) -> None:
        settings, seen = self._image.settings, self._canvas.seen.center()
        orientation = change(settings.orientation)
        self._canvas.centreOn(QPointF(*settings.orientation.place_in(orientation, seen.x(), seen.y())))
        self._image.settings = replace(settings, orientation=orientation)
        self.orientationChanged.emit()

    def _on_clipping_toggled(self, shown: bool) -> None:
        self._image.settings = replace(self._image.settings, show_clipping=shown)

    def _on_colour_map_chosen(self, name: str) -> None:
        self._image.settings = replace(self._image.settings, colour_map=name)

    def _on_levels_dragged(self, black: float, white: float) -> None:
        self._image.settings = with_levels(self._image.settings, black, white)

    def _reset_levels(self) -> None:
        self._image.settings = replace(self._image.settings, levels=Levels())
        self._histogram.setLevels(0.0, 1.0)

    def _on_source_opened(self, _: OpenSource) -> None:
        self._reset_levels()  # another camera's levels mean nothing here


class ComponentController(QObject):
    """Shows one component of a frame or all, distances by the camera's scale. Never changes the camera."""

    def __init__(
        self,
        actions: ComponentActions,
        view: ComponentView,
        histogram: HistogramPanel,
        context: SourceContext,
    ) -> None:
        super().__init__(context.window)
        self._actions = actions
        self._histogram = histogram
        self._image = context.image
        self._coordinates = CameraWatch(context.open_sources, read_scan3d, may_change)
        self._polarisation = CameraWatch(context.open_sources, is_polarised)
        view.componentChosen.connect(self._on_component_chosen)
        view.sideBySideToggled.connect(self._on_side_by_side_toggled)
        actions.polarisedViewChosen.connect(self._on_polarised_view_chosen)
        bridge = Bridge(self)
        actions.actionPolarised.toggled.connect(self._on_polarised_toggled)
        bridge.bind(self._polarisation.changed, actions.actionPolarised.setChecked)
        bridge.bind(self._coordinates.changed, self._on_coordinates_changed)
        bridge.bind(context.open_sources.opened, self._on_source_opened)

    def _on_component_chosen(self, label: str) -> None:
        # Levels and colours of one component mean nothing in another: each keeps its own.
        before, latest = self._image.settings, self._image.latest
        shown = before.component or (latest.label if latest is not None else "")
        if label == shown:
            return
        settings = before.choosing(label, shown)
        self._image.settings = settings
        self._histogram.setLevels(settings.levels.black, settings.levels.white)
        self._actions.setColourMap(settings.colour_map)
        self._actions.setPolarisedView(settings.polarised)

    def _on_side_by_side_toggled(self, wanted: bool) -> None:
        self._image.settings = replace(self._image.settings, side_by_side=wanted)

    def _on_polarised_view_chosen(self, view: PolarisedView) -> None:
        self._image.settings = replace(self._image.settings, polarised=view)

    def _on_polarised_toggled(self, polarised: bool) -> None:
        if not polarised and self._image.settings.polarised is not PolarisedView.MOSAIC:
            self._on_polarised_view_chosen(PolarisedView.MOSAIC)
            self._actions.setPolarisedView(PolarisedView.MOSAIC)

    def _on_coordinates_changed(self, scan: Scan3d) -> None:
        self._image.settings = replace(self._image.settings, scan=scan)

    def _on_source_opened(self, _: OpenSource) -> None:
        before = self._image.settings
        if before.component or before.appearances or before.polarised is not PolarisedView.MOSAIC:
            mosaic = PolarisedView.MOSAIC
            self._image.settings = replace(before, component="", appearances={}, polarised=mosaic)
        self._actions.setPolarisedView(PolarisedView.MOSAIC)


class PointCloudController(QObject):
    """Draws the points of the newest frame while their window is open. Never changes the camera."""

    def __init__(self, action: QAction, context: SourceContext) -> None:
        super().__init__(context.window)
        self._window = context.window
        self.model = PointCloudModel(lambda: context.image.frame, lambda: context.image.settings.scan)
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
        """Close the window. Return whether drawing ended within `timeout` seconds."""
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

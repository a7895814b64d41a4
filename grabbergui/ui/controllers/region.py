"""Joins the region that is drawn to the camera's Width, Height and offsets."""

from __future__ import annotations

from collections.abc import Callable

from PyQt5.QtCore import QObject, pyqtSignal

from grabbergui.core.errors import GrabberError
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.region import Region
from grabbergui.models.changes.undo_history import Step
from grabbergui.models.connection import Connection, LinkState, OpenSource
from grabbergui.models.features import sensor_region
from grabbergui.models.picture.picture import PictureModel
from grabbergui.ui.bridge import Bridge
from grabbergui.ui.views.main_window import MainWindow
from grabbergui.ui.widgets.drawing_tool import Purpose


class RegionController(QObject):
    """Draws the part of the sensor to send, and takes the whole sensor again."""

    failed = pyqtSignal(str)
    """What did not work, for the window's error bar."""

    def __init__(self, window: MainWindow, connection: Connection, picture: PictureModel) -> None:
        super().__init__(window)
        self._window = window
        self._connection = connection
        self._picture = picture
        self._possible = False
        self._bridge = bridge = Bridge(self)
        bridge.bind(connection.opened, self._on_connection_opened)
        bridge.bind(connection.state_changed, self._on_connection_state_changed)
        window.actionRegion.triggered.connect(lambda: window.picture.draw(Purpose.SENSOR_REGION))
        window.actionFullSensor.triggered.connect(lambda: self._change(sensor_region.apply_full))
        window.picture.drawing.regionDrawn.connect(self._on_region_drawn)
        self._enable()

    def _on_region_drawn(self, purpose: Purpose, region: Region) -> None:
        frame = self._picture.frame
        if purpose is not Purpose.SENSOR_REGION or frame is None:
            return
        wanted = self._picture.settings.orientation.to_frame(region, frame.width, frame.height)
        self._change(lambda grabber: sensor_region.apply(grabber, wanted))

    def _change(self, change: Callable[[FrameGrabber], Region]) -> None:
        source = self._connection.source
        if source is None or source.hands is None:
            return
        hands, step = source.hands, Step(self.tr("Region of the sensor"))

        def job() -> Region:
            with hands.journal.within(step):
                return change(hands)

        def failed(error: GrabberError) -> None:
            text = self.tr("the region could not be changed: {0}").format(error)
            self._bridge.call(lambda: self.failed.emit(text))

        # The picture is another now: whatever was zoomed into may be gone.
        source.worker.submit(
            job,
            done=lambda _: self._bridge.call(self._window.picture.canvas.fit),
            failed=failed,
        )

    def _on_connection_opened(self, source: OpenSource) -> None:
        grabber = source.grabber
        if grabber is None or source.read_only:
            return

        def done(possible: bool) -> None:
            self._bridge.call(lambda: self._allow(source, possible))

        source.worker.submit(lambda: sensor_region.has_region(grabber), done=done)

    def _allow(self, source: OpenSource, possible: bool) -> None:
        self._possible = possible and source is self._connection.source
        self._enable()

    def _on_connection_state_changed(self, state: LinkState, _: str) -> None:
        if state in (LinkState.CLOSED, LinkState.OPENING):
            self._possible = False
            self._window.picture.drawing.cancel()
        self._enable()

    def _enable(self) -> None:
        possible = self._possible and self._connection.state.connected
        self._window.actionRegion.setEnabled(possible)
        self._window.actionFullSensor.setEnabled(possible)

"""Joins the region that is drawn to the camera's Width, Height and offsets."""

from __future__ import annotations

from collections.abc import Callable

from PyQt5.QtCore import QObject, pyqtSignal

from grabbergui.core.errors import GrabberError
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.region import Region
from grabbergui.models.changes.history import Step
from grabbergui.models.connection import Connection
from grabbergui.models.features import sensor_region
from grabbergui.models.picture.picture import PictureModel
from grabbergui.ui.bridge import Bridge
from grabbergui.ui.controllers.camera_ability import CameraAbility
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
        self._bridge = Bridge(self)
        window.actionRegion.triggered.connect(lambda: window.picture.draw(Purpose.SENSOR_REGION))
        window.actionFullSensor.triggered.connect(lambda: self._change(sensor_region.apply_full))
        window.picture.drawing.regionDrawn.connect(self._on_region_drawn)
        ability = CameraAbility(
            self, connection, sensor_region.has_region, window.actionRegion, window.actionFullSensor
        )
        ability.ended.connect(window.picture.drawing.cancel)

    def _on_region_drawn(self, purpose: Purpose, region: Region) -> None:
        frame = self._picture.frame
        if purpose is not Purpose.SENSOR_REGION or frame is None:
            return
        wanted = self._picture.settings.orientation.to_frame(region, frame.width, frame.height)
        self._change(lambda grabber: sensor_region.apply(grabber, wanted))

    def _change(self, change: Callable[[FrameGrabber], Region]) -> None:
        source = self._connection.source
        if source is None or source.tracked_grabber is None or source.features is None:
            return
        grabber, step = source.tracked_grabber, Step(self.tr("Region of the sensor"))

        def job() -> Region:
            with grabber.journal.within(step):
                return change(grabber)

        def failed(error: GrabberError) -> None:
            text = self.tr("the region could not be changed: {0}").format(error)
            self._bridge.call(lambda: self.failed.emit(text))

        # The picture is another now: whatever was zoomed into may be gone.
        source.features.run(
            job,
            done=lambda _: self._bridge.call(self._window.picture.canvas.fit),
            failed=failed,
        )

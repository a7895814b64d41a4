"""Controls of the image: streaming, display, measuring, history, region, tuning and calibration."""

from __future__ import annotations

from grabbergui.models.frame_history import FrameHistory
from grabbergui.models.measuring import MeasuringModel
from grabbergui.models.sources import GalleryModel
from grabbergui.models.stream_control import StreamControl
from grabbergui.recording.snapshot import SnapshotWriter
from grabbergui.ui.controllers.calibration import CalibrationOpener, CalibrationViewController
from grabbergui.ui.controllers.frame_data import FrameDataController
from grabbergui.ui.controllers.image import (
    AcquisitionController,
    ComponentController,
    DisplayController,
    PointCloudController,
)
from grabbergui.ui.controllers.last_frames import LastFramesController
from grabbergui.ui.controllers.measuring import MeasuringController
from grabbergui.ui.controllers.recording import PauseController, PlaybackController
from grabbergui.ui.controllers.snapshot_kind import SnapshotKindController
from grabbergui.ui.controllers.source_context import SourceContext
from grabbergui.ui.controllers.tuning import RegionController, TuningController
from grabbergui.ui.run.shut_down import Wait
from grabbergui.ui.views.bases import (
    AcquisitionActions,
    CalibrationActions,
    ComponentActions,
    DisplayActions,
    PauseActions,
    RegionActions,
    TuningActions,
)
from grabbergui.ui.views.main_window import MainWindow
from grabbergui.ui.views.measuring_panels import MeasuringPanels


class ImageControls:
    """The models of the current source's image, and their controllers."""

    def __init__(
        self, window: MainWindow, context: SourceContext, stream: StreamControl, gallery: GalleryModel
    ) -> None:
        self._image = context.image
        self.snapshots = SnapshotWriter()
        self.history = FrameHistory()
        self.measuring = MeasuringModel(lambda: context.image.shown)
        self._make_acquisition(window, context, stream, gallery)
        self._make_display(window, context)
        self._make_measuring(window, context)
        self._make_pause(window, context)
        self._make_tuning(window, context)
        self._make_calibration(window, context)

    def _make_acquisition(
        self, window: MainWindow, context: SourceContext, stream: StreamControl, gallery: GalleryModel
    ) -> None:
        actions = AcquisitionActions(
            window.actionDisconnect,
            window.actionStart,
            window.actionStop,
            window.actionSnapshot,
            window.actionPointCloud,
        )
        self.acquisition = AcquisitionController(
            actions, window.image, context, stream, gallery, self.snapshots
        )
        self.snapshot_kind = SnapshotKindController(window.menuSnapshotKind, context.preferences)
        self.last_frames = LastFramesController(
            window.actionSaveLastFrames, context, self.history, self.snapshots
        )

    def _make_display(self, window: MainWindow, context: SourceContext) -> None:
        actions = DisplayActions(
            window.actionCrosshair,
            window.actionGrid,
            window.actionClipping,
            window.actionTurnRight,
            window.actionTurnLeft,
            window.actionMirrorX,
            window.actionMirrorY,
            window.actionUpright,
            window.colourMapChosen,
        )
        components = ComponentActions(
            window.setColourMap,
            window.actionPolarised,
            window.polarisedViewChosen,
            window.setPolarisedView,
        )
        self.display = DisplayController(actions, window.image, window.histogram, context)
        self.components = ComponentController(components, window.image, window.histogram, context)
        self.frame_data = FrameDataController(window.actionFrameData, context)
        self.points = PointCloudController(window.actionShowPoints, context)

    def _make_measuring(self, window: MainWindow, context: SourceContext) -> None:
        panels = MeasuringPanels(
            window.histogram,
            window.focus,
            window.profile,
            window.histogramDock,
            window.focusDock,
            window.profileDock,
        )
        self.measures = MeasuringController(
            window.image, panels, window.status, window.actionClipping, context, self.measuring
        )
        self.display.orientationChanged.connect(self.measures.show_marks)

    def _make_pause(self, window: MainWindow, context: SourceContext) -> None:
        actions = PauseActions(window.actionPause, window.actionStepBack, window.actionStepForward)
        self.pausing = PauseController(actions, window.image.pauseBar, context, self.history)
        self.playback = PlaybackController(actions, window.image.playbackBar, context)

    def _make_tuning(self, window: MainWindow, context: SourceContext) -> None:
        region = RegionActions(window.actionRegion, window.actionFullSensor)
        tuning = TuningActions(
            window.actionExpose,
            window.actionBalance,
            window.actionExposeRegion,
            window.actionBalanceRegion,
        )
        self.region = RegionController(region, window.image, context)
        self.tuning = TuningController(tuning, window.image, window.image.tasks, context)

    def _make_calibration(self, window: MainWindow, context: SourceContext) -> None:
        actions = CalibrationActions(window.actionLoadCalibration, window.actionShowCalibration)
        self.calibrating = CalibrationOpener(window.actionCalibrate, context)
        self.calibration = CalibrationViewController(actions, context)
        self.calibrating.saved.connect(self.calibration.load)
        window.closing.connect(self.calibrating.close)

    def waits(self) -> tuple[Wait, ...]:
        """Return what is to be waited for at the end of the program, in this order."""
        return (
            ("the image", self._image.detach),
            ("the last images", self.history.detach),
            ("the measurements", self.measuring.close),
            ("the point cloud", self.points.shut_down),
            ("the one-push tuning", self.tuning.shut_down),
            ("a snapshot", self.snapshots.wait),
        )

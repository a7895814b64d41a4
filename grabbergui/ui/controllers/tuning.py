"""One-push exposure and white balance, and the region of interest drawn on the image."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from PyQt5.QtCore import QObject

from grabbergui.core.errors import GrabberError
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.pixels import Region
from grabbergui.core.sfnc import Role
from grabbergui.models.error_text import error_text
from grabbergui.models.features import sensor_region
from grabbergui.models.image.region_edit import RegionLimits
from grabbergui.models.one_push import (
    OnePush,
    Tuning,
    balance,
    can_balance,
    can_expose,
    expose,
    has_once,
    let_camera,
)
from grabbergui.models.open_source import LinkState, OpenSource
from grabbergui.models.tuning import TuningRun
from grabbergui.models.unavailable import Unavailable
from grabbergui.models.undo_steps import UndoStep
from grabbergui.ui.actions import set_available
from grabbergui.ui.controllers.camera_ability import CameraAbility
from grabbergui.ui.controllers.source_context import SourceContext
from grabbergui.ui.gui_thread import Bridge
from grabbergui.ui.views.bases import DrawableView, RegionActions, RegionImageView, TuningActions
from grabbergui.ui.widgets.drawing_tool import Purpose
from grabbergui.ui.widgets.task_stack import TaskRow, TaskStack


class TuningController(QObject):
    """Tunes by the whole image, by the camera's own function if it has one, or by a drawn region."""

    def __init__(
        self,
        actions: TuningActions,
        view: DrawableView,
        tasks: TaskStack,
        context: SourceContext,
    ) -> None:
        super().__init__(context.window)
        self._actions = actions
        self._view = view
        self._tasks = tasks
        self._open_sources = context.open_sources
        self._image = context.image
        self._messages = context.messages
        self._push = OnePush()
        self._row: TaskRow | None = None
        bridge = Bridge(self)
        bridge.bind(self._push.progressed, self._on_progressed)
        bridge.bind(self._push.succeeded, self._messages.notice)
        bridge.bind(self._push.failed, self._messages.error)
        bridge.bind(self._push.ended, self._on_ended)
        bridge.bind(context.open_sources.state_changed, self._on_source_state_changed)
        self._abilities = {
            CameraAbility(self, context.open_sources, can_expose, Unavailable.EXPOSURE): (
                actions.actionExpose,
                actions.actionExposeRegion,
            ),
            CameraAbility(self, context.open_sources, can_balance, Unavailable.BALANCE): (
                actions.actionBalance,
                actions.actionBalanceRegion,
            ),
        }
        "The actions that need each ability, and the stream."
        for ability in self._abilities:
            ability.changed.connect(self._enable)
        # Not over the bridge: work in progress has to stop before the camera is closed.
        context.open_sources.closing.connect(self._on_source_closing, check_nargs=False)
        view.drawing.regionDrawn.connect(self._on_region_drawn)
        actions.actionExpose.triggered.connect(self.expose)
        actions.actionBalance.triggered.connect(self.balance)
        actions.actionExposeRegion.triggered.connect(partial(self._draw, Purpose.EXPOSURE_REGION))
        actions.actionBalanceRegion.triggered.connect(partial(self._draw, Purpose.BALANCE_REGION))
        self._enable()

    def expose(self) -> None:
        """Set the exposure by the whole image."""
        self._start(self.tr("Exposure"), partial(_by_whole, Role.EXPOSURE, partial(expose, region=None)))

    def balance(self) -> None:
        """Set the white balance by the whole image."""
        whole = partial(_by_whole, Role.BALANCE_RATIO, partial(balance, region=None))
        self._start(self.tr("White balance"), whole)

    def shut_down(self, timeout: float) -> bool:
        """Stop the tuning run. Return whether it ended within `timeout` seconds."""
        self._push.cancel()
        return self._push.wait(timeout)

    def _draw(self, purpose: Purpose, _: bool = False) -> None:
        self._view.draw(purpose)

    def _on_region_drawn(self, purpose: Purpose, region: Region) -> None:
        frame = self._image.frame
        if frame is None:
            return
        seen = self._image.settings.orientation.to_frame(region, frame.width, frame.height)
        if purpose is Purpose.EXPOSURE_REGION:
            self._start(self.tr("Exposure on a region"), partial(expose, region=seen))
        elif purpose is Purpose.BALANCE_REGION:
            self._start(self.tr("White balance on a region"), partial(balance, region=seen))

    def _start(self, name: str, tuning: Tuning) -> None:
        source = self._open_sources.current
        if source is None or source.tracked_grabber is None or source.features is None:
            return
        if not self._push.start(name, tuning, source.tracked_grabber, source.features):
            return
        self._row = self._tasks.begin(name)
        self._row.cancelRequested.connect(self._push.cancel)
        self._enable()

    def _on_progressed(self, share: float, text: str) -> None:
        if self._row is not None:
            self._row.setShare(share)
            self._row.setText(text)

    def _on_ended(self) -> None:
        if self._row is not None:
            self._tasks.end(self._row)
            self._row = None
        self._enable()

    def _on_source_closing(self, _: OpenSource) -> None:
        self._push.cancel()

    def _on_source_state_changed(self, state: LinkState, _: str) -> None:
        self._enable()

    def _enable(self) -> None:
        for ability, actions in self._abilities.items():
            reason = Unavailable.PATIENCE if self._row is not None else ability.unavailable(stream=True)
            for action in actions:
                set_available(action, reason)


def _by_whole(role: Role, otherwise: Tuning, run: TuningRun) -> str:
    """Name the tuning of the whole image: the camera's own, if it can."""
    by_itself = run.call(lambda grabber: has_once(grabber, role))
    return let_camera(run, role) if by_itself else otherwise(run)


class RegionController(QObject):
    """Draws the part of the sensor to send, moves and resizes it, and takes the whole sensor again."""

    def __init__(self, actions: RegionActions, view: RegionImageView, context: SourceContext) -> None:
        super().__init__(context.window)
        self._view = view
        self._open_sources = context.open_sources
        self._image = context.image
        self._messages = context.messages
        self._edited: Region | None = None
        "The part of the sensor at which the handles were placed last."
        self._bridge = Bridge(self)
        actions.actionRegion.triggered.connect(self._draw)
        actions.actionFullSensor.triggered.connect(lambda: self._change(sensor_region.apply_full))
        view.drawing.regionDrawn.connect(self._on_region_drawn)
        view.regionTool.regionChosen.connect(self._on_region_chosen)
        view.painted.connect(self._on_view_painted)
        ability = CameraAbility(
            self,
            context.open_sources,
            sensor_region.has_region,
            Unavailable.REGION,
            actions.actionRegion,
            actions.actionFullSensor,
        )
        ability.ended.connect(view.drawing.cancel)
        ability.ended.connect(view.regionTool.end)

    def _draw(self) -> None:
        if self._image.frame is None:
            text = self.tr(
                "there is no image yet to draw on; start the camera first, or write OffsetX, OffsetY, Width"
                " and Height"
            )
            self._messages.error(text)
            return
        if self._view.regionTool.active:
            self._view.regionTool.end()
            return
        self._view.draw(Purpose.SENSOR_REGION)
        if (source := self._open_sources.current) is not None and (grabber := source.grabber) is not None:
            source.worker.submit(
                lambda: sensor_region.place_of(grabber),
                key="region",
                done=lambda place: self._bridge.call(lambda: self._edit(source, *place)),
            )

    def _edit(self, source: OpenSource, region: Region, limits: RegionLimits) -> None:
        """Show a region that is not the whole sensor with handles, until another one is drawn."""
        drawing, frame = self._view.drawing, self._image.frame
        idle = drawing.purpose is Purpose.SENSOR_REGION and not drawing.started
        if source is self._open_sources.current and idle and region != limits.whole and frame is not None:
            self._edited = region
            self._view.editRegion(region, limits, self._image.settings.orientation)

    def _on_view_painted(self) -> None:
        """Let the handles follow the image, which shows another region some frames after it was chosen."""
        frame, tool = self._image.frame, self._view.regionTool
        if tool.active and frame is not None:
            shown = Region(frame.offset_x, frame.offset_y, frame.width, frame.height)
            if shown != self._edited:
                self._edited = shown
                tool.setFrame(shown, self._image.settings.orientation)

    def _on_region_chosen(self, region: Region) -> None:
        self._change(lambda grabber: sensor_region.apply_on_sensor(grabber, region))

    def _on_region_drawn(self, purpose: Purpose, region: Region) -> None:
        frame = self._image.frame
        if purpose is not Purpose.SENSOR_REGION or frame is None:
            return
        wanted = self._image.settings.orientation.to_frame(region, frame.width, frame.height)
        self._change(lambda grabber: sensor_region.apply(grabber, wanted))

    def _change(self, change: Callable[[FrameGrabber], Region]) -> None:
        source = self._open_sources.current
        if source is None or source.tracked_grabber is None or source.features is None:
            return
        grabber, step = source.tracked_grabber, UndoStep(self.tr("Region of the sensor"))

        def job() -> Region:
            with grabber.journal.within(step):
                return change(grabber)

        def failed(error: GrabberError) -> None:
            text = self.tr("the region could not be changed: {0}").format(error_text(error))
            self._bridge.call(lambda: self._messages.error(text))

        # The image has another size: the part that was zoomed into may be gone.
        source.features.run(
            job,
            done=lambda _: self._bridge.call(self._fit),
            failed=failed,
        )

    def _fit(self) -> None:
        if not self._view.regionTool.active:
            self._view.canvas.fit()

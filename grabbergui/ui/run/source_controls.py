"""Controls of the open sources: finding, opening, tiles, state, triggers, recording and sharing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from grabbergui.models.messages import MessageModel
from grabbergui.models.open_source import OpenSource
from grabbergui.models.recording import Recordings
from grabbergui.models.sharing import Sharing
from grabbergui.models.source_opener import SourceOpener
from grabbergui.models.sources import GalleryModel, SourceListModel
from grabbergui.models.status import StatusModel
from grabbergui.models.triggers import Triggers
from grabbergui.rig.ui.controller import NewRigController, RigController
from grabbergui.terminal import remote_terminal
from grabbergui.ui.actions import set_available
from grabbergui.ui.controllers.frames_to_record import FramesToRecordController
from grabbergui.ui.controllers.gallery import GalleryController
from grabbergui.ui.controllers.ip_address import IpAddressController
from grabbergui.ui.controllers.recording import RecordingController
from grabbergui.ui.controllers.sharing import SharingController
from grabbergui.ui.controllers.source_context import SourceContext
from grabbergui.ui.controllers.sources import SourcesController
from grabbergui.ui.controllers.status import StatusController
from grabbergui.ui.controllers.triggers import TriggerController
from grabbergui.ui.run.shut_down import Wait
from grabbergui.ui.views.main_window import MainWindow
from grabbergui.ui.widgets.share_chip import ShareChip

FIRST_URI = "sim:colour"
"""The source of a first start: a camera on which every control has an effect, white balance too."""


class SourceControls:
    """The models of the open sources, and their controllers."""

    def __init__(
        self, window: MainWindow, context: SourceContext, opener: SourceOpener, messages: MessageModel
    ) -> None:
        sources = context.open_sources
        self.source_list = SourceListModel()
        self.gallery = GalleryModel(sources)
        self.recordings = Recordings(sources, messages)
        self.sharing = Sharing(sources, opener.stream, remote_terminal)
        self.status = StatusModel(sources)
        self.status.recorded = self.recordings.runs
        self.share_chip = ShareChip(window)
        window.statusbar.addPermanentWidget(self.share_chip)
        self.frames_to_record = FramesToRecordController(window.menuFramesToRecord, window.recordingBar)
        self.recording = RecordingController(
            window.actionRecord, window.recordingBar, context, self.recordings, self.frames_to_record
        )
        self.sharer = SharingController(window.actionShare, self.share_chip, context, self.sharing)
        tasks = window.image.tasks
        self.sources = SourcesController(
            window.sources, self.source_list, opener, context, tasks, self.confirm_closing, messages
        )
        self.address = IpAddressController(window.sources, window, self.source_list)
        self.tiles = GalleryController(
            window.gallery, window.image, self.gallery, context, self.status, self.confirm_closing
        )
        self.status_bar = StatusController(window.status, window.image, context, self.status, messages)
        triggers = Triggers(sources, self.status, messages)
        self.triggers = TriggerController(window.image.triggerBar, context, triggers)
        self.new_rig = NewRigController(
            window.actionNewRig, context, self.source_list, self.sources.connect_to
        )
        self.rig = RigController(window.actionRig, context)
        self.recording.playRequested.connect(self.sources.play)
        window.setPanes(context.preferences.panes, context.preferences.separate_zoom)
        self._join_actions(window)

    def _join_actions(self, window: MainWindow) -> None:
        for action in (window.actionConnect, window.actionConnectStill):
            set_available(action, window.sources.unavailable)
            window.sources.connectableChanged.connect(partial(set_available, action))
        window.actionConnect.triggered.connect(window.sources.requestConnect)
        window.actionConnectStill.triggered.connect(window.sources.requestStill)
        window.actionDisconnect.triggered.connect(self.sources.disconnect_current)
        window.actionBeside.triggered.connect(window.sources.requestBeside)
        window.actionNextSource.triggered.connect(self.tiles.take_next)
        window.panesChosen.connect(self.tiles.show_panes)
        window.separateZoomToggled.connect(self.tiles.separate_zoom)
        self.status_bar.simulationRequested.connect(lambda: self.sources.connect_to(FIRST_URI))
        self.status_bar.addressRequested.connect(window.actionAddress.trigger)
        self.status_bar.doctorRequested.connect(window.actionDoctor.trigger)
        window.actionSearch.triggered.connect(self.source_list.refresh)

    def confirm_closing(self, closing: Sequence[OpenSource | None], proceed: Callable[[], None]) -> None:
        """Call `proceed`, which closes these sources; ask first if one is recorded or read by others."""
        self.recording.confirm(closing, lambda: self.sharer.confirm(closing, proceed))

    def waits(self) -> tuple[Wait, ...]:
        """Return what is to be waited for at the end of the program, in this order."""
        return (
            ("the thumbnails", self.gallery.close),
            ("a recording", self.recordings.close),
            ("a shared camera", self.sharing.close),
            ("the search for sources", self.source_list.stop),
        )

"""Controls of the current camera's features: panel, favourites, changes, curves, settings files, tables."""

from __future__ import annotations

from grabbergui.models.camera_events import CameraEvents
from grabbergui.models.open_source import OpenSource
from grabbergui.ui.controllers.camera_events import CameraEventsController
from grabbergui.ui.controllers.camera_files import CameraFilesController
from grabbergui.ui.controllers.camera_work import CameraWork
from grabbergui.ui.controllers.changes import ChangesController
from grabbergui.ui.controllers.features import FavouritesController, FeatureController, FeatureMenuController
from grabbergui.ui.controllers.lut import LutController
from grabbergui.ui.controllers.measuring import ValuesController
from grabbergui.ui.controllers.settings import SettingsFilesController, UserSetsController
from grabbergui.ui.controllers.source_context import SourceContext
from grabbergui.ui.views.bases import UndoActions
from grabbergui.ui.views.main_window import MainWindow


class FeatureControls:
    """The controllers of features; the models belong to each open source."""

    def __init__(self, window: MainWindow, context: SourceContext) -> None:
        rows = (window.features.rows, window.favourites.rows)
        self.features = FeatureController(window.features, window.favourites, window)
        self.work = CameraWork(window.image.tasks, context)
        self.settings_files = SettingsFilesController(context, self.work)
        self.user_sets = UserSetsController(window.actionUserSets, context, self.work)
        self.camera_files = CameraFilesController(window.actionCameraFiles, context, self.work)
        self.lut = LutController(window.actionLookUpTable, context, self.work)
        undo = UndoActions(window.actionUndo, window.actionRedo)
        self.changes = ChangesController(undo, window.changes, rows, context)
        events = CameraEvents()
        self.events = CameraEventsController(window.actionEvents, context, events)
        self.values = ValuesController(window.values, window.valuesDock, context, events)
        self.favourites = FavouritesController(window, window.favourites, context, self.features)
        self.feature_menu = FeatureMenuController(context, rows, self.favourites)
        self.feature_menu.plotRequested.connect(self.values.plot)
        self.settings_files.accept_drops()
        window.actionSaveSettings.triggered.connect(self.settings_files.ask_save)
        window.actionLoadSettings.triggered.connect(self.settings_files.ask_load)
        window.actionCompareSettings.triggered.connect(self.settings_files.ask_compare)
        window.actionCompareFiles.triggered.connect(self.settings_files.ask_compare_files)

    def show(self, source: OpenSource | None) -> None:
        """Show the features of the source that is the current one now; None if there is none."""
        if source is None:
            self.features.set_model(None)
        elif source.grabber is not None:
            self.features.set_model(source.features)
            self.favourites.restore(source.grabber.info)

    def forget(self, source: OpenSource) -> None:
        """Drop what was shown for a source that is closed for good."""
        if source.features is not None:
            self.features.forget(source.features)

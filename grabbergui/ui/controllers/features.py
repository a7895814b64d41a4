"""The feature panel, and the pinned controls of each model of camera with the menu that pins them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

from PyQt5.QtCore import QObject, QPoint, Qt, pyqtSignal
from PyQt5.QtWidgets import QApplication, QMenu

from grabbergui.core.features import Feature, FeatureDescription, FeatureKind
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.sfnc import Role, role_of
from grabbergui.core.shell_words import shell_word
from grabbergui.models.features.pinned import MOST_PINNED, controlled_by, moved, placed, without
from grabbergui.models.features.tree import FeatureTreeModel
from grabbergui.models.features.value_history import PLOTTABLE
from grabbergui.models.unavailable import Unavailable
from grabbergui.ui.actions import set_available
from grabbergui.ui.controllers.source_context import SourceContext
from grabbergui.ui.editors.feature_row import FeatureRows
from grabbergui.ui.gui_thread import Bridge, Pacer
from grabbergui.ui.preferences import LAYOUT_VERSION, camera_model
from grabbergui.ui.views.bases import Layout
from grabbergui.ui.views.favourites import FavouritesStrip
from grabbergui.ui.views.feature_panel import FeaturePanel


class FeatureController(QObject):
    """Shows the model's features in both views, and writes what the user changes there."""

    def __init__(
        self, panel: FeaturePanel, favourites: FavouritesStrip, parent: QObject | None = None
    ) -> None:
        super().__init__(parent or panel)
        self._panel = panel
        self._favourites = favourites
        self._model: FeatureTreeModel | None = None
        self._chosen: tuple[str, ...] | None = None
        "The user's favourites; None for those that suit any camera."
        self._bridge: Bridge | None = None
        self._held: set[str] = set()
        "Names of the controls that are being dragged or typed into."
        # A thousand features may arrive at once, and each may need a new editor.
        self._pacer = Pacer(self)
        for rows in (panel.rows, favourites.rows):
            rows.edited.connect(self._on_rows_edited)
            rows.executed.connect(self._on_rows_executed)
            rows.held.connect(self._on_rows_held)
            rows.released.connect(self._on_rows_released)
            rows.explanationRequested.connect(self._on_rows_explanation_requested)
        panel.watchedChanged.connect(self._watch)

    def set_model(self, model: FeatureTreeModel | None) -> None:
        """Show another source's features, or none."""
        if self._bridge is not None:
            self._bridge.close()
            self._bridge = None
        if self._model is not None:
            self._model.watch(())
            for name in self._held:
                self._model.release(name)
        self._held.clear()
        self._model = model
        self._chosen = None
        if model is not None:
            self._bridge = Bridge(self)
            self._bridge.bind(model.feature_changed, self._on_model_feature_changed)
            self._bridge.bind(model.structure_changed, self._show_structure)
        self._show_structure()
        self._show_known()

    def forget(self, model: FeatureTreeModel) -> None:
        """Delete the controls of a closed source."""
        if model is self._model:
            self.set_model(None)
        self._panel.forget(model)
        self._favourites.forget(model)

    def set_locked(self, reason: str) -> None:
        """Lock every control and show the reason; with an empty reason, unlock them."""
        for rows in (self._panel.rows, self._favourites.rows):
            rows.setLocked(reason)

    @property
    def favourites(self) -> tuple[str, ...]:
        """Names of the pinned features that the camera has."""
        model = self._model
        if model is None:
            return ()
        names = self._chosen if self._chosen is not None else model.favourites
        return tuple(name for name in names if model.description(name) is not None)

    def show_favourites(self, names: Sequence[str] | None) -> None:
        """Pin these until another source is shown; with None, the usual ones."""
        self._chosen = tuple(names) if names is not None else None
        self._fill_favourites()
        self._watch()
        self._show_known()

    def _show_structure(self) -> None:
        self._pacer.clear()
        model = self._model
        if model is None:
            self._favourites.setFavourites([])
            self._panel.setTree(None)
            self._panel.setElsewhere(frozenset())
            return
        self._fill_favourites()
        self._panel.setTree(model.root, self.favourites, model)
        self._watch()

    def _fill_favourites(self) -> None:
        if (model := self._model) is not None:
            descriptions = [self._favourite(model, name) for name in self.favourites]
            self._favourites.setFavourites(descriptions, model)
            pinned = controlled_by(self.favourites, lambda name: model.description(name) is not None)
            self._panel.setElsewhere(pinned)

    def _show_known(self) -> None:
        """Show the features read already, unless their controls show them."""
        for feature in self._model.known if self._model is not None else ():
            if any(
                rows.shown(feature.name) is not feature for rows in (self._panel.rows, self._favourites.rows)
            ):
                self._on_model_feature_changed(feature)

    def _favourite(self, model: FeatureTreeModel, name: str) -> FeatureDescription:
        """Name a favourite by its role, which is short and the same for every camera."""
        titles = {
            Role.EXPOSURE: self.tr("Exposure"),
            Role.GAIN: self.tr("Gain"),
            Role.FRAME_RATE: self.tr("Frame rate"),
        }
        description = model.description(name) or FeatureDescription(name=name, kind=FeatureKind.FLOAT)
        role = role_of(name)
        title = titles.get(role, description.title) if role is not None else description.title
        return replace(description, display_name=title)

    def _watch(self) -> None:
        if self._model is not None:
            self._model.watch(self._panel.watched.union(self.favourites))

    def _on_model_feature_changed(self, feature: Feature) -> None:
        self._pacer.add(feature.name, partial(self._show, feature))

    def _show(self, feature: Feature) -> None:
        self._favourites.setFeature(feature)
        self._panel.setFeature(feature)

    def _on_rows_edited(self, name: str, value: object) -> None:
        if self._model is not None and isinstance(value, int | float | str):
            self._model.write(name, value)

    def _on_rows_executed(self, name: str) -> None:
        if self._model is not None:
            self._model.execute(name)

    def _on_rows_held(self, name: str) -> None:
        if self._model is not None:
            self._held.add(name)
            self._model.hold(name)

    def _on_rows_explanation_requested(self, name: str) -> None:
        if self._model is not None:
            self._model.explain(name)

    def _on_rows_released(self, name: str) -> None:
        self._held.discard(name)
        if self._model is not None:
            self._model.release(name)


class FavouritesController(QObject):
    """Remembers the favourites and the layout of the window for each model of camera."""

    def __init__(
        self,
        layout: Layout,
        strip: FavouritesStrip,
        context: SourceContext,
        features: FeatureController,
    ) -> None:
        super().__init__(context.window)
        self._layout = layout
        self._messages = context.messages
        self._features = features
        self._preferences = context.preferences
        self._model = ""
        "Model of the current camera; empty if there is none."
        Bridge(self).bind(context.open_sources.closing, lambda _: self.keep_layout())
        strip.dropped.connect(self.place)

    def restore(self, info: DeviceInfo) -> None:
        """Arrange the window as it was for this model of camera, whose features are shown."""
        self._model = camera_model(info)
        known = self._preferences.favourites_of(self._model)
        if known is not None:
            self._features.show_favourites(known)
        layout = self._preferences.layout_of(self._model)
        if layout is not None:
            self._layout.restoreState(layout, LAYOUT_VERSION)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the pinned controls."""
        return self._features.favourites

    def place(self, name: str, index: int) -> None:
        """Pin a feature before the one at `index`."""
        if name not in self.names and len(self.names) >= MOST_PINNED:
            text = self.tr("no more than {0} controls can be pinned; unpin one first")
            self._messages.error(text.format(MOST_PINNED))
            return
        self._change(lambda names: placed(names, name, index))

    def add(self, name: str) -> None:
        """Pin a feature after the others."""
        self.place(name, len(self.names))

    def remove(self, name: str) -> None:
        """Unpin a feature."""
        self._change(lambda names: without(names, name))

    def move(self, name: str, steps: int) -> None:
        """Move a pinned control by `steps` places."""
        self._change(lambda names: moved(names, name, steps))

    def reset(self) -> None:
        """Pin the usual controls."""
        self._features.show_favourites(None)
        self._preferences.keep_favourites(self._model, None)

    def keep_layout(self) -> None:
        """Remember the arrangement of the window for the current camera."""
        if self._model:
            self._preferences.keep_layout_of(self._model, self._layout.saveState(LAYOUT_VERSION))
            self._model = ""

    def _change(self, change: Callable[[tuple[str, ...]], tuple[str, ...]]) -> None:
        names = change(self.names)
        if self._model and names != self.names:
            self._features.show_favourites(names)
            self._preferences.keep_favourites(self._model, names)


class FeatureMenuController(QObject):
    """The context menu of any feature."""

    plotRequested = pyqtSignal(FeatureDescription)

    def __init__(
        self,
        context: SourceContext,
        shown: Sequence[FeatureRows],
        favourites: FavouritesController,
    ) -> None:
        super().__init__(context.window)
        self._favourites = favourites
        self._window = context.window
        self._open_sources = context.open_sources
        self.menu: QMenu | None = None
        "The menu that is open, if any."
        for rows in shown:
            rows.menuRequested.connect(self._on_menu_requested)

    def _on_menu_requested(self, name: str, where: QPoint) -> None:
        source = self._open_sources.current
        description = source.features.description(name) if source and source.features else None
        if source is None or source.features is None or description is None:
            return
        menu = QMenu(self._window)
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        menu.setToolTipsVisible(True)
        if description.kind in PLOTTABLE:
            menu.addAction(self.tr("&Plot over time"), lambda: self.plotRequested.emit(description))
        self._add_favourites(menu, name)
        menu.addSeparator()
        menu.addAction(self.tr("&Copy the name"), lambda: _copy(shell_word(name)))
        feature = source.features.feature(name)
        if feature is not None and feature.value is not None:
            text = shell_word(f"{name}={feature.text}")
            menu.addAction(self.tr("Copy name and &value"), lambda: _copy(text))
        menu.aboutToHide.connect(self._on_menu_hidden)
        self.menu = menu
        menu.popup(where)

    def _add_favourites(self, menu: QMenu, name: str) -> None:
        pinned = self._favourites
        if name not in pinned.names:
            menu.addAction(self.tr("P&in"), lambda: pinned.add(name))
            return
        place = pinned.names.index(name)
        menu.addSeparator()
        menu.addAction(self.tr("&Unpin"), lambda: pinned.remove(name))
        last = place + 1 == len(pinned.names)
        for text, steps, reason in (
            (self.tr("Move to the &left"), -1, None if place else Unavailable.FIRST),
            (self.tr("Move to the ri&ght"), 1, Unavailable.LAST if last else None),
        ):
            action = menu.addAction(text, lambda steps=steps: pinned.move(name, steps))
            if action is not None:
                set_available(action, reason)
        menu.addAction(self.tr("Pin t&he usual controls"), pinned.reset)

    def _on_menu_hidden(self) -> None:
        self.menu = None


def _copy(text: str) -> None:
    if (clipboard := QApplication.clipboard()) is not None:
        clipboard.setText(text)

"""Joins the feature panel and the favourites to the feature tree."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from PyQt5.QtCore import QObject

from grabbergui.core.features import Feature, FeatureDescription, FeatureKind
from grabbergui.core.sfnc import Role, role_of
from grabbergui.models.features.shown import controlled_by
from grabbergui.models.features.tree import FeatureTreeModel
from grabbergui.ui.bridge import Bridge
from grabbergui.ui.views.favourites import FavouritesStrip
from grabbergui.ui.views.feature_panel import FeaturePanel
from grabbergui.ui.widgets.section import Pacer


class FeatureController(QObject):
    """Shows the model's features in both views and passes on what people do there."""

    def __init__(
        self, panel: FeaturePanel, favourites: FavouritesStrip, parent: QObject | None = None
    ) -> None:
        super().__init__(parent or panel)
        self._panel = panel
        self._favourites = favourites
        self._model: FeatureTreeModel | None = None
        self._chosen: tuple[str, ...] | None = None
        "Favourites in place of those that suit any camera."
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
        """Delete the controls of a source that is closed."""
        if model is self._model:
            self.set_model(None)
        self._panel.forget(model)
        self._favourites.forget(model)

    def set_locked(self, reason: str) -> None:
        """Lock every control, and say why; with no reason, let them be used again."""
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
        """Show what was read already, unless its controls show it."""
        for feature in self._model.known if self._model is not None else ():
            if any(
                rows.shown(feature.name) is not feature for rows in (self._panel.rows, self._favourites.rows)
            ):
                self._on_model_feature_changed(feature)

    def _favourite(self, model: FeatureTreeModel, name: str) -> FeatureDescription:
        """A favourite under the name of what it is for, which is short and the same for every camera."""
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

    def _on_rows_released(self, name: str) -> None:
        self._held.discard(name)
        if self._model is not None:
            self._model.release(name)

"""*Image → Snapshot format*."""

from __future__ import annotations

from PyQt5.QtCore import QObject
from PyQt5.QtWidgets import QAction, QActionGroup, QMenu

from grabbergui.recording.snapshot import SnapshotKind
from grabbergui.ui.preferences import Preferences


class SnapshotKindController(QObject):
    """Offers the kinds of snapshots, and remembers the choice."""

    def __init__(self, menu: QMenu, preferences: Preferences) -> None:
        super().__init__(menu)
        self._preferences = preferences
        titles = {
            SnapshotKind.USUAL: self.tr("PNG, or TIFF above 8 bits"),
            SnapshotKind.TIFF: self.tr("TIFF, the sensor's values"),
            SnapshotKind.RAW: self.tr("Raw payload with a description"),
        }
        group = QActionGroup(self)
        self.actions: dict[SnapshotKind, QAction] = {}
        for kind, title in titles.items():
            self.actions[kind] = action = QAction(title, group)
            action.setCheckable(True)
            action.setChecked(kind is preferences.snapshot_kind)
            action.setData(kind)
        menu.addActions(group.actions())
        group.triggered.connect(self._on_group_triggered)

    def _on_group_triggered(self, action: QAction) -> None:
        self._preferences.snapshot_kind = action.data()

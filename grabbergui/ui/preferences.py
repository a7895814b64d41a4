"""The user's preferences, kept between starts."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from urllib.parse import quote

from PyQt5.QtCore import (
    QByteArray,
    QSettings,
    QStandardPaths,
)

from grabbergui.core.identity import DeviceInfo
from grabbergui.recording.snapshot import SnapshotKind
from grabbergui.ui.theme import Theme

MOST_RECENT = 10
"Most sources remembered that were opened."
LAYOUT_VERSION = 3
"Incremented when docks change so much that older layouts no longer fit."

PANES = (1, 2, 4, 6)
"Numbers of cameras that can be shown side by side."


def camera_model(info: DeviceInfo) -> str:
    """Return the model of a camera, under which its preferences are kept; its URI if it has no model."""
    return " ".join(part for part in (info.vendor, info.model) if part) or info.uri


class Preferences:
    """A few named settings in QSettings; with None nothing is kept, as in tests and offscreen."""

    def __init__(self, store: QSettings | None) -> None:
        self._store = store
        self._passing: dict[str, object] = {}
        self._look: Theme | None = None

    @classmethod
    def of_user(cls) -> Preferences:
        """Return the preferences of the user who runs the program."""
        return cls(QSettings("grabbergui", "grabbergui"))

    @property
    def unwritable(self) -> str:
        """The file in which preferences cannot be kept; empty if they can."""
        return "" if self._store is None or self._store.isWritable() else self._store.fileName()

    def look_for_now(self, theme: Theme) -> None:
        """Use this theme for this run only, until another is chosen."""
        self._look = theme

    @property
    def geometry(self) -> QByteArray | None:
        """Where the window was."""
        value = self._get("window/geometry")
        return value if isinstance(value, QByteArray) else None

    @property
    def layout(self) -> QByteArray | None:
        """Where its docks were."""
        value = self._get("window/layout")
        return value if isinstance(value, QByteArray) else None

    def keep_window(self, geometry: QByteArray, layout: QByteArray) -> None:
        """Remember both."""
        self._set("window/geometry", geometry)
        self._set("window/layout", layout)

    def favourites_of(self, model: str) -> list[str] | None:
        """Names of the features that were pinned for a model of camera; None if none were chosen."""
        value = self._get(_of_model(model, "favourites"))
        return [name for name in value.split(",") if name] if isinstance(value, str) else None

    def keep_favourites(self, model: str, names: Sequence[str] | None) -> None:
        """Remember the pinned features; None returns to the usual ones."""
        # As one text: QSettings returns an empty list as None.
        self._set(_of_model(model, "favourites"), ",".join(names) if names is not None else None)

    def layout_of(self, model: str) -> QByteArray | None:
        """Where the docks were when a camera of this model was closed."""
        value = self._get(_of_model(model, "layout"))
        return value if isinstance(value, QByteArray) else None

    def keep_layout_of(self, model: str, layout: QByteArray) -> None:
        """Remember it."""
        self._set(_of_model(model, "layout"), layout)

    @property
    def recent(self) -> list[str]:
        """URIs of sources that were opened, the last one first."""
        return self._list("sources/recent")

    def note_source(self, uri: str) -> None:
        """Remember that a source was opened."""
        others = [known for known in self.recent if known != uri]
        self._set("sources/recent", [uri, *others][:MOST_RECENT])

    @property
    def left_open(self) -> list[str]:
        """URIs of the sources that were open when the window was closed, the current one first."""
        return self._list("sources/left-open")

    @left_open.setter
    def left_open(self, uris: list[str]) -> None:
        self._set("sources/left-open", uris)

    @property
    def typed(self) -> list[str]:
        """URIs of sources that the user added."""
        return self._list("sources/typed")

    @typed.setter
    def typed(self, uris: list[str]) -> None:
        self._set("sources/typed", uris)

    def share_name(self, network: str) -> str:
        """The name under which a camera was last shared on a network; empty if none was."""
        name = self._get(f"share/{network}")
        return name if isinstance(name, str) else ""

    def keep_share_name(self, network: str, name: str) -> None:
        """Remember it."""
        self._set(f"share/{network}", name)

    @property
    def snapshot_folder(self) -> Path:
        """Where snapshots go."""
        value = self._get("snapshots/folder")
        if isinstance(value, str) and value:
            return Path(value)
        pictures = QStandardPaths.writableLocation(QStandardPaths.PicturesLocation)
        return Path(pictures or Path.home()) / "grabbergui"

    @snapshot_folder.setter
    def snapshot_folder(self, folder: Path) -> None:
        self._set("snapshots/folder", str(folder))

    @property
    def snapshot_kind(self) -> SnapshotKind:
        """The kind of files of snapshots."""
        try:
            return SnapshotKind(self._get("snapshots/kind"))
        except ValueError:
            return SnapshotKind.USUAL

    @snapshot_kind.setter
    def snapshot_kind(self, kind: SnapshotKind) -> None:
        self._set("snapshots/kind", kind.value)

    @property
    def panes(self) -> int:
        """How many cameras are shown side by side, one of `PANES`."""
        value = str(self._get("window/panes"))
        return int(value) if value in map(str, PANES) else PANES[0]

    @panes.setter
    def panes(self, count: int) -> None:
        self._set("window/panes", count)

    @property
    def separate_zoom(self) -> bool:
        """Whether each of several cameras has a zoom of its own."""
        return str(self._get("window/separate_zoom")).lower() == "true"

    @separate_zoom.setter
    def separate_zoom(self, separate: bool) -> None:
        self._set("window/separate_zoom", separate)

    @property
    def theme(self) -> Theme:
        """The theme chosen."""
        if self._look is not None:
            return self._look
        try:
            return Theme(self._get("window/theme"))
        except ValueError:
            return Theme.AUTO

    @theme.setter
    def theme(self, theme: Theme) -> None:
        self._look = None
        self._set("window/theme", theme.value)

    def _list(self, key: str) -> list[str]:
        """Return several texts; QSettings returns a list of one as a single text."""
        value = self._get(key)
        if isinstance(value, str):
            return [value]
        return [str(text) for text in value] if isinstance(value, list) else []

    def _get(self, key: str) -> object:
        return self._store.value(key) if self._store is not None else self._passing.get(key)

    def _set(self, key: str, value: object) -> None:
        if self._store is None:
            self._passing[key] = value
        elif value is None:
            self._store.remove(key)
        else:
            self._store.setValue(key, value)


def _of_model(model: str, what: str) -> str:
    """Return the key of a model, whose name may contain a slash, QSettings' separator."""
    return f"cameras/{quote(model, safe=' ')}/{what}"

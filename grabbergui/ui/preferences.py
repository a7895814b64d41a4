"""What the window remembers from one run to the next."""

from __future__ import annotations

from pathlib import Path

from PyQt5.QtCore import QByteArray, QSettings, QStandardPaths

from grabbergui.ui.theme import Theme

MOST_RECENT = 10
LAYOUT_VERSION = 2
"Raised when docks change so much that an old layout makes no sense."


class Preferences:
    """A few named settings over QSettings; with None nothing is kept, as in tests and offscreen."""

    def __init__(self, store: QSettings | None) -> None:
        self._store = store
        self._passing: dict[str, object] = {}
        self._look: Theme | None = None

    @classmethod
    def of_user(cls) -> Preferences:
        """Those of the user who runs the program."""
        return cls(QSettings("grabbergui", "grabbergui"))

    def look_for_now(self, theme: Theme) -> None:
        """Want this look for this run only, until another is chosen."""
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

    @property
    def recent(self) -> list[str]:
        """URIs of sources that were opened, the last one first."""
        return self._list("sources/recent")

    def note_source(self, uri: str) -> None:
        """A source was opened."""
        others = [known for known in self.recent if known != uri]
        self._set("sources/recent", [uri, *others][:MOST_RECENT])

    @property
    def typed(self) -> list[str]:
        """URIs of sources that were named by hand."""
        return self._list("sources/typed")

    @typed.setter
    def typed(self, uris: list[str]) -> None:
        self._set("sources/typed", uris)

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
    def theme(self) -> Theme:
        """Which look is wanted."""
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
        """Several texts; QSettings gives back a single one as such."""
        value = self._get(key)
        if isinstance(value, str):
            return [value]
        return [str(text) for text in value] if isinstance(value, list) else []

    def _get(self, key: str) -> object:
        return self._store.value(key) if self._store is not None else self._passing.get(key)

    def _set(self, key: str, value: object) -> None:
        if self._store is not None:
            self._store.setValue(key, value)
        else:
            self._passing[key] = value

"""The sources found, and a field for the address of one that was not."""

from __future__ import annotations

from collections.abc import Sequence

from PyQt5.QtCore import QEvent, QPoint, QStringListModel, Qt, pyqtSignal
from PyQt5.QtWidgets import (
    QCompleter,
    QLabel,
    QLineEdit,
    QListWidget,
    QListWidgetItem,
    QMenu,
    QPushButton,
    QToolButton,
    QWidget,
)

from grabbergui.models.sources import ListedSource
from grabbergui.ui.theme import icon
from grabbergui.ui.widgets.source_delegate import CURRENT_ROLE, SOURCE_ROLE, SourceDelegate
from grabbergui.ui.windows import load_form


class SourceListView(QWidget):
    """Setters for the sources and the state; signals for the choice."""

    connectRequested = pyqtSignal(str)
    """The URI of the source that was chosen in the list."""
    stillRequested = pyqtSignal(str)
    """The URI of a source to open, but not to start."""
    besideRequested = pyqtSignal(str)
    """The URI of an additional source to open."""
    addressEntered = pyqtSignal(str)
    """The text of the address field."""
    disconnectRequested = pyqtSignal()
    refreshRequested = pyqtSignal()
    forgetRequested = pyqtSignal(str)
    """The URI of a source named by hand that is not wanted any more."""

    addressEdit: QLineEdit
    refreshButton: QToolButton
    sourceList: QListWidget
    hintLabel: QLabel
    connectButton: QPushButton
    besideButton: QPushButton

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("source_list", self)
        self._connected = False
        self._current = ""
        self._select_current = False
        "Whether to select the current source once it is listed."
        self._recent = QStringListModel(self)
        completer = QCompleter(self._recent, self)
        completer.setFilterMode(Qt.MatchFlag.MatchContains)
        completer.setCaseSensitivity(Qt.CaseSensitivity.CaseInsensitive)
        self.addressEdit.setCompleter(completer)
        self.sourceList.setItemDelegate(SourceDelegate(self.sourceList))
        self.sourceList.setMouseTracking(True)
        if (viewport := self.sourceList.viewport()) is not None:
            viewport.setAutoFillBackground(False)  # the cards lie on the window itself
        self.addressEdit.returnPressed.connect(self._on_address_entered)
        self.addressEdit.textChanged.connect(self._update_button)
        self.refreshButton.clicked.connect(self.refreshRequested)
        self.sourceList.itemActivated.connect(self._on_item_activated)
        self.sourceList.itemSelectionChanged.connect(self._update_button)
        self.sourceList.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.sourceList.customContextMenuRequested.connect(self._on_menu_requested)
        self.connectButton.clicked.connect(self._on_connect_clicked)
        self.besideButton.clicked.connect(self.requestBeside)
        self._update_button()

    @property
    def selected(self) -> str:
        """The URI of the source that is selected; empty where none is."""
        items = self.sourceList.selectedItems()
        return items[0].data(SOURCE_ROLE).info.uri if items else ""

    def setSources(self, sources: Sequence[ListedSource]) -> None:
        """Show these sources; the selection stays."""
        selected = self._current if self._select_current or not self.selected else self.selected
        self._select_current &= all(source.info.uri != self._current for source in sources)
        blocked = self.sourceList.blockSignals(True)
        self.sourceList.clear()
        for source in sources:
            item = QListWidgetItem(self.sourceList)
            item.setData(SOURCE_ROLE, source)
            item.setData(CURRENT_ROLE, source.info.uri == self._current)
            item.setData(
                Qt.ItemDataRole.AccessibleTextRole,
                f"{source.info.title} {source.info.uri} {'connected' if source.connected else ''}"
                f" {source.info.note}".strip(),
            )
            item.setToolTip(self._tooltip(source))
            item.setSelected(source.info.uri == selected)
        self.sourceList.blockSignals(blocked)
        self._update_button()

    def setCurrent(self, uri: str, connected: bool) -> None:
        """Mark the source that is open or being opened; empty for none."""
        self._select_current = uri != self._current or self._select_current
        self._current, self._connected = uri, connected
        for row in range(self.sourceList.count()):
            if (item := self.sourceList.item(row)) is None:
                continue
            mine = item.data(SOURCE_ROLE).info.uri == uri
            item.setData(CURRENT_ROLE, mine)
            if mine:
                self._select_current = False
                self.sourceList.setCurrentItem(item)
        self._update_button()

    def setRecent(self, uris: Sequence[str]) -> None:
        """Set the completions of the address field."""
        self._recent.setStringList(list(uris))

    def setSearching(self, searching: bool) -> None:
        """Whether a search is in progress."""
        self.refreshButton.setEnabled(not searching)

    def focusAddress(self) -> None:
        """Put the cursor into the address field."""
        self.addressEdit.setFocus(Qt.FocusReason.ShortcutFocusReason)
        self.addressEdit.selectAll()

    def requestConnect(self) -> None:
        """As if the connect button were pressed while nothing is open."""
        address = self.addressEdit.text().strip()
        if address:
            self.addressEntered.emit(address)
        elif self.selected:
            self.connectRequested.emit(self.selected)
        else:
            self.focusAddress()

    def requestStill(self) -> None:
        """Open the typed or chosen source without starting it; focus the address field if there is none."""
        if chosen := self.addressEdit.text().strip() or self.selected:
            self.stillRequested.emit(chosen)
        else:
            self.focusAddress()

    def requestBeside(self) -> None:
        """Open the typed or chosen source as an additional one, as its button does."""
        if other := self._other():
            self.addressEdit.clear()
            self.besideRequested.emit(other)
        else:
            self.focusAddress()

    def changeEvent(self, event: QEvent | None) -> None:
        """Redraw the button's icon in the colours of another look."""
        super().changeEvent(event)
        if event is not None and event.type() == QEvent.Type.PaletteChange and hasattr(self, "connectButton"):
            self._update_button()

    def _on_address_entered(self) -> None:
        if address := self.addressEdit.text().strip():
            self.addressEntered.emit(address)

    def _on_item_activated(self, item: QListWidgetItem) -> None:
        self.connectRequested.emit(item.data(SOURCE_ROLE).info.uri)

    def _on_menu_requested(self, place: QPoint) -> None:
        item = self.sourceList.itemAt(place)
        if item is None:
            return
        source: ListedSource = item.data(SOURCE_ROLE)
        menu = QMenu(self)
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        menu.addAction(self.tr("Connect"), lambda: self.connectRequested.emit(source.info.uri))
        menu.addAction(self.tr("Connect without starting"), lambda: self.stillRequested.emit(source.info.uri))
        if self._connected and not source.connected:
            menu.addAction(self.tr("Open beside"), lambda: self.besideRequested.emit(source.info.uri))
        if source.manual:
            menu.addAction(self.tr("Forget"), lambda: self.forgetRequested.emit(source.info.uri))
        menu.popup(self.sourceList.mapToGlobal(place))

    def _on_connect_clicked(self) -> None:
        if self._leaves():
            self.disconnectRequested.emit()
        else:
            self.requestConnect()

    def _leaves(self) -> bool:
        """Whether the button disconnects: a source is open and no other was chosen."""
        return self._connected and not self._other()

    def _other(self) -> str:
        """The typed or chosen source, if it is not the current one; else empty."""
        return self.addressEdit.text().strip() or (self.selected if self.selected != self._current else "")

    def _update_button(self) -> None:
        leaves, items = self._leaves(), self.sourceList.selectedItems()
        opened = self._connected and bool(items) and items[0].data(SOURCE_ROLE).connected
        text = self.tr("Disconnect") if leaves else self.tr("Show") if opened else self.tr("Connect")
        self.connectButton.setText(text)
        self.connectButton.setIcon(icon("disconnect" if leaves else "connect", self.palette()))
        self.connectButton.setProperty("iconName", "disconnect" if leaves else "connect")
        self.besideButton.setVisible(self._connected and bool(self._other()))
        self.besideButton.setEnabled(bool(self.addressEdit.text().strip()) or not opened)
        self.connectButton.setEnabled(leaves or bool(self.addressEdit.text().strip() or self.selected))

    def _tooltip(self, source: ListedSource) -> str:
        info = source.info
        rows = {
            self.tr("source"): info.uri,
            self.tr("vendor"): info.vendor,
            self.tr("model"): info.model,
            self.tr("name"): info.user_name,
            self.tr("serial"): info.serial,
            self.tr("address"): info.address,
            self.tr("version"): info.version,
            self.tr("seen on"): info.interface,
            self.tr("note"): info.note,
        }
        return "\n".join(f"{name}: {value}" for name, value in rows.items() if value)

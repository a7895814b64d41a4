"""The sources found, painted with name, address and state; a field for the address of one that was not."""

from __future__ import annotations

from collections.abc import Sequence

from PyQt5.QtCore import (
    QEvent,
    QItemSelectionModel,
    QPoint,
    QStringListModel,
    Qt,
    QTimer,
    pyqtSignal,
)
from PyQt5.QtGui import QKeySequence, QResizeEvent, QShowEvent
from PyQt5.QtWidgets import (
    QCompleter,
    QLabel,
    QLineEdit,
    QListWidgetItem,
    QMenu,
    QPushButton,
    QShortcut,
    QToolButton,
    QWidget,
)

from grabbergui.models.ip_address import has_address
from grabbergui.models.sources import ListedSource, takes_description
from grabbergui.models.unavailable import Unavailable
from grabbergui.ui.actions import set_available
from grabbergui.ui.form_loader import load_form
from grabbergui.ui.shown_text import set_tooltip
from grabbergui.ui.theme import icon
from grabbergui.ui.views.gallery import Gallery
from grabbergui.ui.widgets.source_cards import CURRENT_ROLE, SOURCE_ROLE, CardArea, SourceCards


class SourceListView(QWidget):
    """Setters for the sources and the state; signals for the choice."""

    connectRequested = pyqtSignal(str)
    """The URI of the source that was chosen in the list."""
    stillRequested = pyqtSignal(str)
    """The URI of a source to open, but not to start."""
    besideRequested = pyqtSignal(str)
    """The URI of an additional source to open."""
    descriptionRequested = pyqtSignal(str)
    """The URI of a camera to open with a description from a file."""
    addressRequested = pyqtSignal(object)
    """The `DeviceInfo` of a camera whose IP address is to be set."""
    connectableChanged = pyqtSignal(object)
    """Why *Connect* is not available (`Unavailable`), or None; depends on the selection and the address."""
    addressEntered = pyqtSignal(str)
    """The text of the address field."""
    disconnectRequested = pyqtSignal()
    refreshRequested = pyqtSignal()
    forgetRequested = pyqtSignal(str)
    """The URI of a source the user added that is not wanted any more."""

    addressEdit: QLineEdit
    refreshButton: QToolButton
    scrollArea: CardArea
    gallery: Gallery
    sourceList: SourceCards
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
        self._unseen = False
        "Whether the selected source should come into view."
        self.gallery.filled.connect(self._hide_open)
        self.gallery.filled.connect(self._show_selected)
        if (bar := self.scrollArea.verticalScrollBar()) is not None:
            bar.rangeChanged.connect(self._scroll)
        self._recent = QStringListModel(self)
        completer = QCompleter(self._recent, self)
        completer.setFilterMode(Qt.MatchFlag.MatchContains)
        completer.setCaseSensitivity(Qt.CaseSensitivity.CaseInsensitive)
        self.addressEdit.setCompleter(completer)
        self.sourceList.currentItemChanged.connect(lambda: self._show_selected())
        self.addressEdit.returnPressed.connect(self._on_address_entered)
        self.addressEdit.textChanged.connect(self._on_address_changed)
        self.refreshButton.clicked.connect(self.refreshRequested)
        self.sourceList.itemActivated.connect(self._on_item_activated)
        self.sourceList.itemSelectionChanged.connect(self._update_button)
        self.sourceList.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.sourceList.customContextMenuRequested.connect(self._on_menu_requested)
        QShortcut(
            QKeySequence(Qt.Key.Key_Delete),
            self.sourceList,
            self._on_delete_pressed,
            context=Qt.ShortcutContext.WidgetShortcut,
        )
        self.connectButton.clicked.connect(self._on_connect_clicked)
        self.besideButton.clicked.connect(self.requestBeside)
        self._update_button()

    @property
    def selected(self) -> str:
        """The URI of the selected source; empty if none is selected."""
        items = self.sourceList.selectedItems()
        return items[0].data(SOURCE_ROLE).info.uri if items else ""

    def setSources(self, sources: Sequence[ListedSource]) -> None:
        """Show these sources; keep the selection, and what is in view: a search may bring others any time."""
        chosen = self.selected
        selected = self._current if self._select_current or not chosen else chosen
        self._select_current &= all(source.info.uri != self._current for source in sources)
        before = self.sourceList.currentItem()
        current = "" if before is None else before.data(SOURCE_ROLE).info.uri
        blocked = self.sourceList.blockSignals(True)
        self.sourceList.clear()
        for source in sources:
            item = QListWidgetItem(self.sourceList)
            item.setData(SOURCE_ROLE, source)
            item.setData(CURRENT_ROLE, source.info.uri == self._current)
            item.setData(
                Qt.ItemDataRole.AccessibleTextRole,
                " ".join((source.info.title, source.info.uri, source.note, source.detail)).strip(),
            )
            set_tooltip(item, self._tooltip(source))
            if source.info.uri == current:
                self.sourceList.setCurrentItem(item, QItemSelectionModel.SelectionFlag.NoUpdate)
            item.setSelected(source.info.uri == selected)
        self._hide_open()
        if selected != chosen:
            self._show_selected()
        self.sourceList.blockSignals(blocked)
        self._update_button()

    def _hide_open(self, *_: bool) -> None:
        """List an open source in its tile only, if there are tiles."""
        tiles = bool(self.gallery.tiles)
        for row in range(self.sourceList.count()):
            if (item := self.sourceList.item(row)) is not None:
                item.setHidden(tiles and item.data(SOURCE_ROLE).connected)
        self.sourceList.updateGeometry()
        self.scrollArea.updateGeometry()

    def cardsCut(self, pixels: int) -> int:
        """Return the height of as many tiles and cards at the end as take at least so many pixels.

        Less, if so few would stay that the list has to be higher.
        """
        content = self.scrollArea.widget()
        if pixels <= 0 or content is None:
            return 0
        needed, gap = content.sizeHint().height(), self.gallery.tilesLayout.spacing()
        heights = [tile.height() + gap for tile in self.gallery.tiles] + self.sourceList.heights()
        cut = max(0, needed - sum(heights))  # the hint below the cards
        for height in reversed(heights):
            if cut >= pixels:
                break
            cut += height
        return min(cut, max(pixels, needed - self.scrollArea.minimumHeight()))

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
        """Show whether a search is in progress."""
        set_available(self.refreshButton, Unavailable.SEARCH if searching else None)

    def focusAddress(self) -> None:
        """Put the cursor into the address field."""
        self.addressEdit.setFocus(Qt.FocusReason.ShortcutFocusReason)
        self.addressEdit.selectAll()

    def requestConnect(self) -> None:
        """Open the typed or chosen source, as the connect button does."""
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

    def showEvent(self, event: QShowEvent | None) -> None:
        """Bring the selected source into view."""
        super().showEvent(event)
        self._show_selected()

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Keep the selected source in view where it becomes lower."""
        super().resizeEvent(event)
        self._show_selected()

    def _show_selected(self, *_: bool) -> None:
        self._unseen = True
        QTimer.singleShot(0, self._scroll)

    def _scroll(self, *_: int) -> None:
        """Scroll to the selected card; again while the list has not got the height of its cards."""
        content, cards = self.scrollArea.widget(), self.sourceList
        items = cards.selectedItems()
        if not self._unseen or content is None or not items:
            return
        if (bar := self.scrollArea.verticalScrollBar()) is not None:
            bar.setValue(0)  # no card above it is cut for nothing
        if items[0].isHidden():  # the source has a tile
            current = next((tile for tile in self.gallery.tiles if tile.property("current")), None)
            self._unseen = False
            if current is not None:
                self.scrollArea.ensureWidgetVisible(current, 0, 0)
            return
        card = cards.visualItemRect(items[0])
        self._unseen = content.height() < cards.y() + card.bottom()
        card.moveTopLeft(cards.mapTo(content, card.topLeft()))
        self.scrollArea.ensureVisible(card.center().x(), card.center().y(), 0, card.height() // 2 + 1)

    def changeEvent(self, event: QEvent | None) -> None:
        """Redraw the button's icon in the colours of another theme."""
        super().changeEvent(event)
        if event is not None and event.type() == QEvent.Type.PaletteChange and hasattr(self, "connectButton"):
            self._update_button()

    def _on_address_entered(self) -> None:
        if address := self.addressEdit.text().strip():
            self.addressEntered.emit(address)

    def _on_address_changed(self, text: str) -> None:
        completer = self.addressEdit.completer()
        if not text and completer is not None and (popup := completer.popup()) is not None:
            popup.hide()  # otherwise it takes the next keys
        self._update_button()

    def _on_item_activated(self, item: QListWidgetItem) -> None:
        self.connectRequested.emit(item.data(SOURCE_ROLE).info.uri)

    def _on_menu_requested(self, place: QPoint) -> None:
        item = self.sourceList.itemAt(place)
        if item is None:
            return
        source: ListedSource = item.data(SOURCE_ROLE)
        menu = QMenu(self)
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        uri = source.info.uri
        current = self._connected and uri == self._current
        if source.connected and not source.lost:
            if current:
                menu.addAction(self.tr("Disconnect"), self.disconnectRequested.emit)
            else:
                menu.addAction(self.tr("Show"), lambda: self.connectRequested.emit(uri))
        else:
            menu.addAction(self.tr("Connect"), lambda: self.connectRequested.emit(uri))
            menu.addAction(self.tr("Connect without starting"), lambda: self.stillRequested.emit(uri))
            if self._connected and not current:
                menu.addAction(self.tr("Open beside"), lambda: self.besideRequested.emit(uri))
        if takes_description(uri) and not source.connected:
            menu.addAction(
                self.tr("Connect with a description file…"),
                lambda: self.descriptionRequested.emit(uri),
            )
        if has_address(source.info) and not source.connected:
            menu.addAction(self.tr("IP address…"), lambda: self.addressRequested.emit(source.info))
        if source.manual:
            menu.addAction(self.tr("Forget"), lambda: self.forgetRequested.emit(uri))
        menu.popup(self.sourceList.mapToGlobal(place))

    def _on_delete_pressed(self) -> None:
        """Forget the selected source if the user added it."""
        for item in self.sourceList.selectedItems():
            source: ListedSource = item.data(SOURCE_ROLE)
            if source.manual and not source.connected:
                self.forgetRequested.emit(source.info.uri)

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

    @property
    def unavailable(self) -> Unavailable | None:
        """Why the typed or selected source cannot be opened or shown; None if it can."""
        items = self.sourceList.selectedItems()
        lost = bool(items) and items[0].data(SOURCE_ROLE).lost
        return None if self._other() or lost or not self._connected else Unavailable.PRESENT

    def _update_button(self) -> None:
        leaves, items, typed = (
            self._leaves(),
            self.sourceList.selectedItems(),
            self.addressEdit.text().strip(),
        )
        opened = self._connected and not typed and bool(items) and items[0].data(SOURCE_ROLE).connected
        text = self.tr("Disconnect") if leaves else self.tr("Show") if opened else self.tr("Connect")
        self.connectButton.setText(text)
        self.connectButton.setIcon(icon("disconnect" if leaves else "connect", self.palette()))
        self.connectButton.setProperty("iconName", "disconnect" if leaves else "connect")
        self.besideButton.setVisible(self._connected and bool(self._other()))
        set_available(self.besideButton, Unavailable.SHOWN if opened else None)
        set_available(self.connectButton, None if leaves or typed or self.selected else Unavailable.CHOICE)
        self.connectableChanged.emit(self.unavailable)

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
            self.tr("note"): source.note,
            self.tr("did not open"): source.problem,
        }
        return "\n".join(f"{name}: {value}" for name, value in rows.items() if value)

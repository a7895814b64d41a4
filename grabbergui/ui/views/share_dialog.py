"""The dialog *Camera → Share…*: a box for each network, who is connected, and what they changed."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import (
    QCheckBox,
    QDialog,
    QGridLayout,
    QGroupBox,
    QLabel,
    QLineEdit,
    QListWidget,
    QPushButton,
    QSpinBox,
    QTreeWidget,
    QTreeWidgetItem,
    QWidget,
)

from grabbergui.core.visible_text import shortened
from grabbergui.models.change import Change
from grabbergui.models.share import Network, ReaderRate, Remedy, ShareOptions, ShareState, ShareStatus
from grabbergui.models.unavailable import Unavailable
from grabbergui.ui.actions import set_available
from grabbergui.ui.form_loader import load_form
from grabbergui.ui.screen import fit_screen
from grabbergui.ui.shown_text import set_cell_tooltip, set_tooltip
from grabbergui.ui.widgets.columns import size_columns
from grabbergui.ui.widgets.labels import ElidedLabel

MOST_TITLE = 60
"Characters of the camera's name."
MOST_PROBLEM = 160
"Characters of a problem that are shown; its tooltip has all of them."


class ShareNetworkBox(QGroupBox):
    """Name and options of one network, its state, and a problem with its remedy."""

    shareRequested = pyqtSignal()
    stopRequested = pyqtSignal()
    remedyRequested = pyqtSignal()
    """The button beside the problem."""

    nameEdit: QLineEdit
    serverLabel: QLabel
    serverEdit: QLineEdit
    hereBox: QCheckBox
    domainLabel: QLabel
    domainSpin: QSpinBox
    shareButton: QPushButton
    stateLabel: ElidedLabel
    problemLabel: QLabel
    remedyButton: QPushButton
    gridLayout: QGridLayout

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("share_network", self)
        # The fields of all networks stand in the same columns.
        for column, widgets in (
            (0, (self.serverLabel, self.domainLabel)),
            (2, (self.hereBox, self.shareButton)),
        ):
            width = max(widget.sizeHint().width() for widget in widgets)
            self.gridLayout.setColumnMinimumWidth(column, width)
        self.domainSpin.setSpecialValueText(self.tr("as ROS_DOMAIN_ID"))
        self._running = False
        self.shareButton.clicked.connect(self._on_share_clicked)
        self.remedyButton.clicked.connect(self.remedyRequested)

    def setNetwork(self, network: Network) -> None:
        """Show the options of a network."""
        yarp = network is Network.YARP
        for widget in (self.serverLabel, self.serverEdit, self.hereBox):
            widget.setVisible(yarp)
        for widget in (self.domainLabel, self.domainSpin):
            widget.setVisible(not yarp)
        what = self.tr("The port's name") if yarp else self.tr("The node's name, which prefixes its topics")
        set_tooltip(self.nameEdit, what)
        self.nameEdit.setAccessibleName(what)

    def options(self) -> ShareOptions:
        """Return what is typed and chosen."""
        domain = self.domainSpin.value()
        return ShareOptions(
            self.nameEdit.text().strip(),
            self.serverEdit.text().strip(),
            self.hereBox.isChecked(),
            None if domain < 0 else domain,
        )

    def setOptions(self, options: ShareOptions) -> None:
        """Fill the fields."""
        self.nameEdit.setText(options.name)
        self.serverEdit.setText(options.nameserver)
        self.hereBox.setChecked(options.own_nameserver)
        self.domainSpin.setValue(-1 if options.domain is None else options.domain)

    def setStatus(self, status: ShareStatus | None) -> None:
        """Show the state; None if the camera is not shared on this network."""
        self._running = status is not None and status.running
        stopping = status is not None and status.state is ShareState.STOPPING
        for field in (self.nameEdit, self.serverEdit, self.hereBox, self.domainSpin):
            field.setEnabled(not self._running and not stopping)
        self.shareButton.setText(self.tr("Stop") if self._running else self.tr("Share"))
        set_available(self.shareButton, Unavailable.PATIENCE if stopping else None)
        self.stateLabel.setText(self._state_text(status))
        self.stateLabel.setVisible(bool(self.stateLabel.text()))
        set_tooltip(self.stateLabel, "\n".join(status.places if status is not None else ()))
        problem = status.problem if status is not None else ""
        self.problemLabel.setText(shortened(problem[:1].upper() + problem[1:], MOST_PROBLEM))
        set_tooltip(self.problemLabel, problem)
        self.problemLabel.setVisible(bool(problem))
        remedy = status.remedy if status is not None and problem else None
        self.remedyButton.setVisible(remedy is not None)
        if remedy is Remedy.NAME_SERVER:
            self.remedyButton.setText(self.tr("Run a name server here"))
        elif remedy is Remedy.COMMAND:
            self.remedyButton.setText(self.tr("Copy the command"))

    def _state_text(self, status: ShareStatus | None) -> str:
        if status is None or status.state is ShareState.FAILED:
            return ""
        if status.state is ShareState.STARTING:
            return self.tr("Starting…")
        if status.state is ShareState.STOPPING:
            return self.tr("Stopping…")
        return status.places[0] if status.places else ""

    def _on_share_clicked(self) -> None:
        if self._running:
            self.stopRequested.emit()
        else:
            self.shareRequested.emit()


class ShareDialog(QDialog):
    """Setters for the shares of the current camera; signals, with the network, for what is requested."""

    shareRequested = pyqtSignal(object)
    """The `Network`; `options` has what is typed."""
    stopRequested = pyqtSignal(object)
    remedyRequested = pyqtSignal(object)

    introLabel: QLabel
    readOnlyBox: QCheckBox
    yarpBox: ShareNetworkBox
    ros2Box: ShareNetworkBox
    readersTree: QTreeWidget
    changesList: QListWidget
    closeButton: QPushButton

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("share_dialog", self)
        self._boxes: Mapping[Network, ShareNetworkBox] = {
            Network.YARP: self.yarpBox,
            Network.ROS2: self.ros2Box,
        }
        for network, box in self._boxes.items():
            box.setNetwork(network)
            self._join(network, box)
        size_columns(
            self.readersTree,
            ("/grabbergui/12345-67ab/1/cam", "100.0 images/s · 100.0 MB/s", "192.168.100.100"),
        )
        self.closeButton.clicked.connect(self.reject)
        fit_screen(self)

    def setCamera(self, title: str) -> None:
        """Name the camera that is shared; empty if none is open."""
        text = self.tr("{0}: others see its image and settings while this window is open.").format(
            shortened(title, MOST_TITLE)
        )
        self.introLabel.setText(text if title else self.tr("No camera is open."))
        for widget in (self.readOnlyBox, *self._boxes.values()):
            widget.setEnabled(bool(title))

    def options(self, network: Network) -> ShareOptions:
        """Return what is typed and chosen for a network."""
        return replace(self._boxes[network].options(), read_only=self.readOnlyBox.isChecked())

    def setOptions(self, network: Network, options: ShareOptions) -> None:
        """Fill the fields of a network."""
        self._boxes[network].setOptions(options)

    def setStatuses(self, statuses: Sequence[ShareStatus]) -> None:
        """Show the state on each network, and who is connected."""
        found = {status.network: status for status in statuses}
        for network, box in self._boxes.items():
            box.setStatus(found.get(network))
        self.readOnlyBox.setEnabled(not any(status.running for status in statuses))
        self._show_readers([rate for status in statuses for rate in status.readers])

    def setChanges(self, changes: Sequence[Change]) -> None:
        """Show what others changed, the newest first."""
        lines = [
            f"{time.strftime('%H:%M:%S', time.localtime(one.time))}  {one}"
            + (f"  · {one.cause}" if one.cause else "")
            for one in changes
        ]
        if lines != [self._line(row) for row in range(self.changesList.count())]:
            self.changesList.clear()
            self.changesList.addItems(lines)

    def _line(self, row: int) -> str:
        item = self.changesList.item(row)
        return item.text() if item is not None else ""

    def _show_readers(self, rates: Sequence[ReaderRate]) -> None:
        """Show one row for each connection; rows that stay keep their place and selection."""
        tree = self.readersTree
        while tree.topLevelItemCount() > len(rates):
            tree.takeTopLevelItem(tree.topLevelItemCount() - 1)
        while tree.topLevelItemCount() < len(rates):
            QTreeWidgetItem(tree)
        for row, rate in enumerate(rates):
            item = tree.topLevelItem(row)
            assert item is not None
            reader = rate.reader
            takes = rate.rate_text or self.tr("no images")
            for column, text in enumerate((reader.name, takes, reader.address, reader.takes)):
                item.setText(column, text)
                set_cell_tooltip(item, column, text)

    def _join(self, network: Network, box: ShareNetworkBox) -> None:
        box.shareRequested.connect(lambda: self.shareRequested.emit(network))
        box.stopRequested.connect(lambda: self.stopRequested.emit(network))
        box.remedyRequested.connect(lambda: self.remedyRequested.emit(network))

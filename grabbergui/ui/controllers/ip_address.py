"""*IP address…* of a camera in the list."""

from __future__ import annotations

from PyQt5.QtCore import QObject
from PyQt5.QtWidgets import QWidget

from grabbergui.core.identity import DeviceInfo
from grabbergui.models.ip_address import IpAddressModel
from grabbergui.models.sources import SourceListModel
from grabbergui.ui.gui_thread import Bridge
from grabbergui.ui.views.ip_address_dialog import IpAddressDialog
from grabbergui.ui.views.source_list import SourceListView


class IpAddressController(QObject):
    """Shows the dialog for one camera at a time, and searches again when it has another address."""

    def __init__(self, view: SourceListView, window: QWidget, sources: SourceListModel) -> None:
        super().__init__(window)
        self._window = window
        self._sources = sources
        self._bridge: Bridge | None = None
        self.model: IpAddressModel | None = None
        self.dialog: IpAddressDialog | None = None
        "While it is shown."
        view.addressRequested.connect(self.show)

    def show(self, info: DeviceInfo) -> None:
        """Show the dialog for a camera."""
        if self.dialog is not None:
            self.dialog.raise_()
            return
        self.model = model = IpAddressModel(info)
        self.dialog = dialog = IpAddressDialog(self._window)
        reason = info.note or self.tr("Its address is {0}.").format(info.address)
        dialog.setCamera(info.title, info.hardware_id, reason)
        dialog.setProposal(*model.proposal())
        self._bridge = bridge = Bridge(self)
        bridge.bind(model.done, self._on_model_done)
        bridge.bind(model.failed, lambda text: dialog.setOutcome(text, good=False))
        dialog.setRequested.connect(self._on_dialog_set_requested)
        dialog.finished.connect(self._on_dialog_finished)
        dialog.show()

    def _on_dialog_set_requested(self, ip: str, mask: str, gateway: str, keep: bool) -> None:
        if self.dialog is not None and self.model is not None:
            self.dialog.setWorking()
            self.model.set(ip, mask, gateway, keep=keep)

    def _on_model_done(self, text: str) -> None:
        if self.dialog is not None:
            self.dialog.setOutcome(text, good=True)
        self._sources.refresh()

    def _on_dialog_finished(self, _: int) -> None:
        dialog, self.dialog = self.dialog, None
        if self._bridge is not None:
            self._bridge.close()
            self._bridge = None
        if dialog is not None:
            dialog.deleteLater()

"""*Camera → Share…*, the chip in the status bar, and the question before readers lose the camera."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace

from PyQt5.QtCore import QObject, Qt, QTimer
from PyQt5.QtGui import QGuiApplication
from PyQt5.QtWidgets import QAction, QMessageBox

from grabbergui.models.open_source import OpenSource
from grabbergui.models.remote_source import RemoteSource
from grabbergui.models.share import DEFAULT_NAMES, Network, Remedy, ShareOptions, ShareStatus
from grabbergui.models.sharing import Sharing, peer_changes
from grabbergui.models.unavailable import why_unavailable
from grabbergui.ui.actions import set_available
from grabbergui.ui.controllers.source_context import SourceContext
from grabbergui.ui.gui_thread import Bridge
from grabbergui.ui.shown_text import question_box
from grabbergui.ui.views.share_dialog import ShareDialog
from grabbergui.ui.widgets.share_chip import ShareChip

AGE_PERIOD_MS = 500
"Milliseconds between two looks at the age of a remote image."
MOST_NAMES = 5
"Most readers that the question names."


class SharingController(QObject):
    """Joins the shares of the current camera with the dialog and the chip."""

    def __init__(self, action: QAction, chip: ShareChip, context: SourceContext, sharing: Sharing) -> None:
        super().__init__(context.window)
        self._action, self._chip, self._window = action, chip, context.window
        self._open_sources, self._sharing, self._image = context.open_sources, sharing, context.image
        self._preferences = context.preferences
        self.dialog: ShareDialog | None = None
        "While it is shown."
        self.question: QMessageBox | None = None
        "The question whether readers may lose the camera, while it is open."
        self._source: OpenSource | None = None
        "The source that the dialog's fields were filled for."
        bridge = Bridge(self)
        bridge.bind(sharing.changed, self._show)
        bridge.bind(context.open_sources.state_changed, lambda *_: self._show())
        bridge.bind(context.open_sources.changed, lambda _: self._show())
        action.triggered.connect(self.show)
        chip.clicked.connect(self.show)
        self._timer = QTimer(self)
        self._timer.setInterval(AGE_PERIOD_MS)
        self._timer.timeout.connect(self._show_chip)
        self._show()

    def show(self) -> None:
        """Show the dialog."""
        if self.dialog is not None:
            self.dialog.raise_()
            self.dialog.activateWindow()
            return
        self._sharing.prepare()
        self.dialog = dialog = ShareDialog(self._window)
        self._source = None
        dialog.shareRequested.connect(self._on_dialog_share_requested)
        dialog.stopRequested.connect(self._on_dialog_stop_requested)
        dialog.remedyRequested.connect(self._on_dialog_remedy_requested)
        dialog.finished.connect(self._on_dialog_finished)
        self._show()
        dialog.show()

    def confirm(self, closing: Sequence[OpenSource | None], proceed: Callable[[], None]) -> None:
        """Call `proceed`, which closes these sources; ask first if others read one of them."""
        self.confirm_for(self._sharing.readers(closing), proceed)

    def confirm_for(self, readers: Sequence[str], proceed: Callable[[], None]) -> None:
        """Call `proceed`, by which these readers lose the camera; ask first if there are any."""
        if not readers:
            proceed()
            return
        if self.question is not None:
            self.question.raise_()
            return
        named = ", ".join(readers[:MOST_NAMES])
        if len(readers) > MOST_NAMES:
            named = self.tr("{0} and {1} more").format(named, len(readers) - MOST_NAMES)
        box = question_box(
            self.dialog or self._window,
            self.tr("Others read this camera: {0}").format(named),
            self.tr("They receive no more images."),
        )
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        box.setWindowTitle(self.tr("Share"))
        stop = box.addButton(self.tr("Stop sharing"), QMessageBox.ButtonRole.AcceptRole)
        keep = box.addButton(self.tr("Keep sharing"), QMessageBox.ButtonRole.RejectRole)
        box.setDefaultButton(keep)
        box.setEscapeButton(keep)

        def answered() -> None:
            self.question = None
            if box.clickedButton() is stop:
                proceed()

        box.finished.connect(lambda _: answered())
        self.question = box
        box.open()

    def _on_dialog_share_requested(self, network: Network) -> None:
        if self.dialog is not None:
            self._share(network, self.dialog.options(network))

    def _on_dialog_stop_requested(self, network: Network) -> None:
        source = self._open_sources.current
        if source is None:
            return
        statuses = [status for status in self._sharing.of(source) if status.network is network]
        readers = [name for status in statuses for name in status.names]
        self.confirm_for(readers, lambda: self._sharing.stop(source, network))

    def _on_dialog_remedy_requested(self, network: Network) -> None:
        source, dialog = self._open_sources.current, self.dialog
        statuses = [status for status in self._sharing.of(source) if status.network is network]
        if dialog is None or not statuses:
            return
        if statuses[0].remedy is Remedy.NAME_SERVER:
            options = replace(dialog.options(network), own_nameserver=True)
            dialog.setOptions(network, options)
            self._share(network, options)
        elif (clipboard := QGuiApplication.clipboard()) is not None:
            clipboard.setText(statuses[0].command)

    def _share(self, network: Network, options: ShareOptions) -> None:
        if (source := self._open_sources.current) is None:
            return
        self._preferences.keep_share_name(network.value, options.name)
        self._sharing.share(source, network, options)

    def _on_dialog_finished(self, _: int) -> None:
        dialog, self.dialog = self.dialog, None
        if dialog is not None:
            dialog.deleteLater()

    def _show(self) -> None:
        source = self._open_sources.current
        reason = why_unavailable(source)
        set_available(self._action, reason)
        statuses = self._sharing.of(source)
        self._show_chip()
        if (dialog := self.dialog) is None:
            return
        dialog.setCamera(source.title if source is not None and reason is None else "")
        if source is not self._source:
            self._source = source
            for network, options in self._first_options(statuses).items():
                dialog.setOptions(network, options)
        dialog.setStatuses(statuses)
        dialog.setChanges(peer_changes(source))

    def _first_options(self, statuses: Sequence[ShareStatus]) -> dict[Network, ShareOptions]:
        """Return the options to fill in: those in use, else those used last."""
        names = {
            network: ShareOptions(self._preferences.share_name(network.value) or name)
            for network, name in DEFAULT_NAMES.items()
        }
        return {**names, **{status.network: status.options for status in statuses}}

    def _show_chip(self) -> None:
        source = self._open_sources.current
        remote = RemoteSource.of(source)
        statuses = [status for status in self._sharing.of(source) if status.running]
        self._chip.setVisible(source is not None)
        if remote is not None and not self._timer.isActive():
            self._timer.start()
        elif remote is None:
            self._timer.stop()
        text, detail = self._share_texts(statuses)
        if remote is not None:
            age = self._age()
            text = " · ".join(filter(None, (remote.text(age), text)))
            detail = f"{remote.detail(age)}\n{detail}"
        self._chip.setState(text, detail)

    def _share_texts(self, statuses: Sequence[ShareStatus]) -> tuple[str, str]:
        if not statuses:
            return "", self.tr("Share this camera with other programs and computers")
        readers = list(dict.fromkeys(name for status in statuses for name in status.names))
        networks = ", ".join(f"{status.network.value} {status.options.name}" for status in statuses)
        text = self.tr("Shared ({0})").format(len(readers))
        detail = self.tr("Shared on {0}").format(networks)
        if readers:
            detail = f"{detail}\n{self.tr('Read by {0}').format(', '.join(readers))}"
        return text, detail

    def _age(self) -> float | None:
        """Return how long ago the newest image was exposed, in seconds; None before the first."""
        frame = self._image.frame
        return max(0.0, time.monotonic() - frame.captured) if frame is not None else None

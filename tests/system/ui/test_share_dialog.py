"""Sharing from the window: the dialog, the chip, and the question before readers lose the camera."""

import pytest
from PyQt5.QtWidgets import QApplication, QPushButton

from grabbergui.models.open_source import LinkState
from grabbergui.models.share import Network, ShareOptions, ShareState
from grabbergui.models.sharing import Served
from grabbergui.net.readers import Reader
from grabbergui.net.yarp.os.name_server import NameServer

URI = "sim:?fps=20&width=64&height=48&serial=SHAREUI"


class Scripted:
    """A server that runs, with the readers that a test names."""

    name = "/camera"

    def __init__(self, *readers):
        self.readers = [Reader(name, "/camera/image_raw", "", 10, 1000) for name in readers]
        self.stopped = 0

    def start(self):
        pass

    def stop(self):
        self.stopped += 1

    def places(self):
        return ["/camera/image_raw in domain 7"]

    def connected(self):
        return self.readers


@pytest.fixture
def shared(app):
    """A camera that the program serves already, to a viewer; the server."""
    server = Scripted("/viewer")
    app.connect(URI)
    app.program.source_controls.sharing.adopt(
        Served(URI, Network.ROS2, ShareOptions("/camera", domain=7), server)
    )
    app.until(lambda: app.program.source_controls.sharing.all_readers)
    yield server
    server.readers = []
    app.until(lambda: not app.program.source_controls.sharing.all_readers)


def dialog(app):
    app.window.actionShare.trigger()
    return app.program.source_controls.sharer.dialog


def answer(app, text):
    app.until(lambda: app.program.source_controls.sharer.question is not None)
    question = app.program.source_controls.sharer.question
    next(button for button in question.findChildren(QPushButton) if button.text() == text).click()
    app.until(lambda: app.program.source_controls.sharer.question is None)


def test_share_is_grey_while_nothing_is_open(app):
    assert not app.window.actionShare.isEnabled()
    app.connect(URI)
    app.until(app.window.actionShare.isEnabled)


def test_a_camera_is_shared_with_a_name_server_of_the_window(app):
    app.connect(URI)
    with NameServer(port=0) as server:
        free = f"127.0.0.1:{server.port_number}"
    box = dialog(app).yarpBox
    assert box.nameEdit.text() == "/grabber"
    box.nameEdit.setText("/share/ui")
    box.serverEdit.setText(free)
    box.shareButton.click()
    app.until(box.remedyButton.isVisible)
    assert box.problemLabel.text() == f"No YARP name server answers at {free}"
    assert box.remedyButton.text() == "Run a name server here"
    box.remedyButton.click()
    app.until(lambda: box.stateLabel.text().startswith("/share/ui at tcp://127.0.0.1:"))
    assert box.problemLabel.isHidden() and not box.nameEdit.isEnabled()
    app.until(lambda: app.program.source_controls.share_chip.text() == "Shared (0)")
    box.shareButton.click()
    app.until(lambda: box.shareButton.text() == "Share")
    assert app.program.source_controls.share_chip.text() == ""
    app.program.source_controls.sharer.dialog.reject()
    assert dialog(app).yarpBox.nameEdit.text() == "/share/ui"


def test_the_dialog_shows_who_takes_what(app, shared):
    shown = dialog(app)
    assert shown.ros2Box.stateLabel.text() == "/camera/image_raw in domain 7"
    assert shown.ros2Box.domainSpin.value() == 7
    app.until(lambda: shown.readersTree.topLevelItemCount() == 1)
    row = shown.readersTree.topLevelItem(0)
    assert [row.text(column) for column in range(4)] == [
        "/viewer",
        "0.0 images/s · 0.0 MB/s",
        "",
        "/camera/image_raw",
    ]
    assert app.program.source_controls.share_chip.text() == "Shared (1)"
    assert "/viewer" in app.program.source_controls.share_chip.toolTip()


def test_stopping_asks_while_others_read(app, shared):
    shown = dialog(app)
    shown.ros2Box.shareButton.click()
    answer(app, "Keep sharing")
    assert not shared.stopped
    shown.ros2Box.shareButton.click()
    answer(app, "Stop sharing")
    app.until(lambda: shared.stopped)


@pytest.mark.parametrize("close", ["disconnect", "window"])
def test_closing_asks_while_others_read(app, shared, close):
    link = app.program.opener
    if close == "disconnect":
        app.window.actionDisconnect.trigger()
    else:
        app.window.actionQuit.trigger()
    answer(app, "Keep sharing")
    assert link.open_sources.state is LinkState.STREAMING and app.window.isVisible()
    if close == "disconnect":
        app.window.actionDisconnect.trigger()
        answer(app, "Stop sharing")
        app.until(lambda: link.open_sources.state is LinkState.CLOSED)


def test_a_window_on_a_remote_camera_says_so(app, make_app, tmp_path):
    app.connect(URI)
    sharing = app.program.source_controls.sharing
    with NameServer(port=0) as server:
        address = f"127.0.0.1:{server.port_number}"
        sharing.share(app.program.open_sources.current, Network.YARP, ShareOptions("/far", address))
        app.until(lambda: sharing.of(app.program.open_sources.current)[0].state is ShareState.ON)
        far = make_app()
        far.connect(f"yarp:/far?nameserver={address}")
        chip = far.program.source_controls.share_chip
        far.until(lambda: chip.text().startswith("YARP /far · "))
        assert chip.text().endswith(" s old")
        assert "A remote camera: /far from 127.0.0.1 over YARP." in chip.toolTip()
        far.program.open_sources.close_all()
        far.until(lambda: far.program.open_sources.wait_closed(0))
        QApplication.processEvents()
        assert chip.isHidden()

"""The window as a person uses it, on the simulated camera."""

import threading
from dataclasses import replace

import cv2
import numpy as np
import pytest
from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QAbstractButton, QAction, QLineEdit

from fakes import ScriptedGrabber
from grabbergui.core.errors import AccessDeniedError, SourceNotFoundError
from grabbergui.core.features import AccessMode, Feature, FeatureKind
from grabbergui.core.grabber import Access
from grabbergui.core.identity import DeviceInfo
from grabbergui.models.open_source import LinkState
from grabbergui.models.source_list import ListedSource
from grabbergui.ui import theme
from grabbergui.ui.editors.feature_editor import ReadingLabel
from grabbergui.ui.editors.number_editors import RangeEditor
from grabbergui.ui.theme import DARK, LIGHT
from grabbergui.ui.widgets.source_delegate import SOURCE_ROLE
from patience import PATIENCE, attempts


def test_the_image_arrives_and_the_state_reports_it(window_desk):
    window_desk.connect()
    window_desk.watch()
    status = window_desk.window.status
    window_desk.until(lambda: "Live" in status.stateLabel.text() and "Mono8" in status.formatLabel.text())
    assert status.stateLabel.property("tone") == "good"
    window_desk.until(lambda: float(status.rateLabel.text().split()[0]) > 5)
    assert "grabbergui" in window_desk.window.windowTitle()
    assert not window_desk.errors


def test_moving_a_slider_changes_the_cameras_register(window_desk):
    window_desk.connect()
    rows = window_desk.window.favourites.rows
    window_desk.until(lambda: rows.rows("ExposureTime") and rows.rows("ExposureTime")[0].editor is not None)
    slider = rows.rows("ExposureTime")[0].editor.slider()
    before = window_desk.grabber.feature("ExposureTime").value
    window_desk.until(slider.isEnabled)
    window_desk.qtbot.keyClick(slider, Qt.Key_PageUp)
    window_desk.until(lambda: window_desk.grabber.feature("ExposureTime").value > before * 1.01)


def test_stop_and_start(window_desk):
    window, link = window_desk.window, window_desk.program.connection
    window_desk.connect()
    window_desk.watch()
    window.actionStop.trigger()
    window_desk.until(lambda: link.state is LinkState.OPEN)
    window_desk.until(lambda: "Stopped" in window.status.stateLabel.text())
    assert not window_desk.grabber.streaming
    assert window.actionStart.isEnabled() and not window.actionStop.isEnabled()
    window.actionStart.trigger()
    window_desk.until(lambda: link.state is LinkState.STREAMING)
    window_desk.watch()


def test_a_snapshot_holds_the_frames_own_pixels(window_desk, tmp_path):
    window_desk.connect()
    window_desk.watch()
    window_desk.window.actionStop.trigger()
    window_desk.until(lambda: window_desk.window.actionStart.isEnabled())
    window_desk.window.actionSnapshot.trigger()
    window_desk.until(lambda: any("Saved" in message for message in window_desk.errors))
    (path,) = (tmp_path / "snapshots").glob("*.png")
    frame = window_desk.program.picture.frame
    assert np.array_equal(cv2.imread(str(path), cv2.IMREAD_UNCHANGED), frame.raw())


def test_a_refused_write_shows_in_the_error_bar_and_can_be_dismissed(window_desk):
    window_desk.connect()
    features = window_desk.program.connection.source.features
    features.write("ExposureTime", -5.0)
    window_desk.until(lambda: window_desk.errors)
    assert "ExposureTime=-5.0" in window_desk.errors[0]
    button = window_desk.window.messages.closeButton
    window_desk.until(button.isVisible)
    window_desk.qtbot.mouseClick(button, Qt.LeftButton)
    assert not window_desk.errors
    window_desk.until(lambda: not window_desk.window.messages.isVisible())
    window_desk.watch()


@pytest.mark.parametrize(
    ("typed", "said"),
    [("192.168.0.10", "write its kind first"), ("nonsense:1", "no known kind")],
)
def test_a_bad_address_is_explained(window_desk, typed, said):
    edit = window_desk.window.sources.addressEdit
    window_desk.qtbot.keyClicks(edit, typed)
    window_desk.qtbot.keyClick(edit, Qt.Key_Return)
    window_desk.until(lambda: window_desk.errors)
    assert said in window_desk.errors[0]
    window_desk.until(lambda: window_desk.program.connection.state is LinkState.CLOSED)


def test_typing_an_address_connects_and_the_button_lets_go(window_desk):
    view = window_desk.window.sources
    window_desk.qtbot.keyClicks(view.addressEdit, "sim:")
    window_desk.qtbot.keyClick(view.addressEdit, Qt.Key_Return)
    window_desk.until(lambda: window_desk.program.connection.state is LinkState.STREAMING)
    window_desk.until(lambda: view.connectButton.text() == "Disconnect")
    window_desk.qtbot.mouseClick(view.connectButton, Qt.LeftButton)
    window_desk.until(lambda: window_desk.program.connection.state is LinkState.CLOSED)
    window_desk.until(lambda: "Not connected" in window_desk.window.status.stateLabel.text())
    assert not window_desk.window.actionSnapshot.isEnabled()


def test_sources_found_are_listed_and_a_refresh_keeps_the_selection(window_desk):
    view = window_desk.window.sources
    one = ListedSource(DeviceInfo("gige:1", vendor="Acme", model="One", serial="1", address="10.0.0.1"))
    two = ListedSource(DeviceInfo("gige:2", vendor="Acme", model="Two", note="in another subnet"))
    view.setSources([one, two])
    view.sourceList.setCurrentRow(1)
    view.setSources([two, one])
    assert view.selected == "gige:2"
    with window_desk.qtbot.waitSignal(view.connectRequested) as asked:
        window_desk.qtbot.mouseClick(view.connectButton, Qt.LeftButton)
    assert asked.args == ["gige:2"]


def test_connecting_and_closing_twenty_times_leaves_no_thread(window_desk):
    before = threading.active_count()
    for _ in range(20):
        window_desk.connect()
        window_desk.program.connection.disconnect()
    assert window_desk.program.connection.wait_closed(PATIENCE)
    window_desk.until(lambda: threading.active_count() == before)


def test_closing_while_it_streams_and_searches_takes_less_than_a_second(desks):
    for watch in attempts(1.0):
        desk = desks()
        desk.program.begin("sim:")
        desk.until(lambda desk=desk: desk.program.connection.state is LinkState.STREAMING)
        with watch:
            desk.window.close()


def test_closing_while_a_camera_does_not_answer_takes_little_more_than_a_second(desks):
    answer = threading.Event()

    def create(uri):
        answer.wait(PATIENCE)
        raise SourceNotFoundError(f"{uri} does not answer")

    for watch in attempts(1.2):
        answer.clear()
        desk = desks()
        note = desk.window.picture.note
        desk.program.connection._create = create
        desk.program.begin("gige:10.255.255.1")
        desk.until(lambda note=note: "Connecting" in note.summaryLabel.text())
        with watch:
            desk.window.close()
        answer.set()


def test_every_control_has_a_name_to_be_read_aloud(window_desk):
    for button in window_desk.window.sources.findChildren(QAbstractButton):
        if isinstance(button.parent(), QLineEdit):
            continue  # Qt's own button that clears the field
        assert button.accessibleName() or button.text(), button.objectName()
    for edit in window_desk.window.sources.findChildren(QLineEdit):
        assert edit.accessibleName() or edit.objectName() == "qt_spinbox_lineedit"
    for action in window_desk.window.toolBar.actions():
        assert action.isSeparator() or (action.text() and not action.icon().isNull()), action.objectName()


def test_no_two_actions_share_a_shortcut(window_desk):
    keys = [
        a.shortcut().toString()
        for a in window_desk.window.findChildren(QAction)
        if not a.shortcut().isEmpty()
    ]
    assert len(keys) == len(set(keys))


def luminance(colour):
    parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


@pytest.mark.parametrize("colours", [LIGHT, DARK], ids=["light", "dark"])
@pytest.mark.parametrize(
    ("ink", "ground"),
    [("text", "window"), ("text", "panel"), ("text", "raised"), ("muted", "window"), ("muted", "panel"),
     ("good", "raised"), ("busy", "raised"), ("bad", "bad_back"), ("text", "bad_back"), ("text", "info_back"),
     ("on_accent", "accent")],
)  # fmt: skip
def test_text_contrasts_with_its_background(colours, ink, ground):
    bright, dim = sorted(
        (luminance(getattr(colours, ink)), luminance(getattr(colours, ground))), reverse=True
    )
    assert (bright + 0.05) / (dim + 0.05) >= 4.5, "WCAG 2.1, AA"


def test_the_look_can_be_changed_while_it_runs(window_desk, qapp):
    before = qapp.palette(), qapp.styleSheet(), qapp.style().objectName()
    try:
        window_desk.window.actionThemeDark.trigger()
        assert window_desk.window.palette().window().color().name() == DARK.window
        window_desk.window.actionThemeLight.trigger()
        assert window_desk.window.palette().window().color().name() == LIGHT.window
        assert window_desk.preferences.theme is theme.Theme.LIGHT
    finally:
        qapp.setStyle(before[2])
        qapp.setStyleSheet(before[1])
        qapp.setPalette(before[0])


class HeldElsewhere(ScriptedGrabber):
    """Another program has control until it lets go; read-only beside it, as GenICam cameras are."""

    held = True

    def open(self, access=Access.CONTROL):
        if self.held and access is not Access.MONITOR:
            raise AccessDeniedError("another application at 10.0.0.5 controls Acme Script; close it there")
        super().open(access)

    def feature(self, name):
        feature = super().feature(name)
        return replace(feature, access=AccessMode.READ_ONLY) if self.access is Access.MONITOR else feature

    def start(self, *, keep_trigger=False):
        if self.access is Access.MONITOR:
            raise AccessDeniedError("the camera sends its pictures to 10.0.0.5")
        super().start()


def test_a_camera_held_by_another_program_can_be_looked_at_and_taken_over(window_desk):
    gain = Feature(name="Gain", kind=FeatureKind.FLOAT, access=AccessMode.READ_WRITE, value=3.0, minimum=0.0,
                   maximum=24.0)  # fmt: skip
    reset = Feature(name="Reset", kind=FeatureKind.COMMAND, access=AccessMode.WRITE_ONLY, category="Other")
    grabber = HeldElsewhere([gain, reset])
    link, window = window_desk.program.connection, window_desk.window
    link._create = lambda uri: grabber
    window_desk.program.sources.connect_to("fake:")
    window_desk.until(lambda: window_desk.errors)
    assert "read only: another application at 10.0.0.5" in window_desk.errors[0]
    rows = window.favourites.rows
    window_desk.until(lambda: rows.rows("Gain") and rows.rows("Gain")[0].editor is not None)
    assert isinstance(rows.rows("Gain")[0].editor, ReadingLabel)
    window.features.filterEdit.setText("reset")
    panel = window.features.rows
    window_desk.until(lambda: panel.rows("Reset") and panel.rows("Reset")[0].editor is not None)
    assert not panel.rows("Reset")[0].editor.isEnabled(), "nor is a command"
    window_desk.until(lambda: "goes to the program" in window.picture.note.summaryLabel.text())
    assert "Read only" in window.status.stateLabel.text()

    button = window.messages.findChild(QAbstractButton, "offerButton")
    assert button.isVisible() and button.text() == "Take control"
    window_desk.qtbot.mouseClick(button, Qt.LeftButton)  # still held
    window_desk.until(lambda: link.state is LinkState.OPEN and len(window_desk.errors) == 1)
    grabber.held = False
    window_desk.until(lambda: window.messages.findChildren(QAbstractButton, "offerButton"))
    button = window.messages.findChildren(QAbstractButton, "offerButton")[-1]
    window_desk.qtbot.mouseClick(button, Qt.LeftButton)
    window_desk.until(lambda: link.state is LinkState.STREAMING and not window_desk.errors)
    window_desk.until(lambda: rows.rows("Gain") and isinstance(rows.rows("Gain")[0].editor, RangeEditor))


def test_take_control_answers_every_time(window_desk):
    gain = Feature(name="Gain", kind=FeatureKind.FLOAT, access=AccessMode.READ_WRITE, value=3.0, minimum=0.0,
                   maximum=24.0)  # fmt: skip
    grabber, link = HeldElsewhere([gain]), window_desk.program.connection
    link._create = lambda uri: grabber
    window_desk.program.sources.connect_to("fake:")

    def offered():
        buttons = window_desk.window.messages.findChildren(QAbstractButton, "offerButton")
        return next((button for button in buttons if button.isVisible()), None)

    window_desk.until(lambda: window_desk.errors and offered())
    assert window_desk.errors[0].startswith("read only")
    for _ in range(2):
        before = link.source
        window_desk.qtbot.mouseClick(offered(), Qt.LeftButton)
        window_desk.until(lambda before=before: link.source not in (before, None) and window_desk.errors)
        window_desk.until(lambda: window_desk.errors[0].startswith("control was not given") and offered())
        assert len(window_desk.errors) == 1


def test_a_source_opened_by_its_address_is_listed_as_connected_and_remembered(window_desk):
    view = window_desk.window.sources
    window_desk.qtbot.keyClicks(view.addressEdit, "sim:?pixel_format=Mono12p")
    window_desk.qtbot.keyClick(view.addressEdit, Qt.Key_Return)
    window_desk.until(lambda: window_desk.program.connection.state is LinkState.STREAMING)
    window_desk.until(lambda: view.sourceList.item(0).data(SOURCE_ROLE).connected)
    assert view.sourceList.count() == 1
    line = view.sourceList.item(0).data(SOURCE_ROLE)
    assert line.connected and line.manual and line.info.model == "Simulated camera"
    assert window_desk.preferences.typed == ["sim:?pixel_format=Mono12p"]
    window_desk.program.connection.disconnect()
    window_desk.until(lambda: not view.sourceList.item(0).data(SOURCE_ROLE).connected)
    view.forgetRequested.emit(line.info.uri)
    window_desk.until(lambda: view.sourceList.count() == 0)
    assert window_desk.preferences.typed == []


class Unreachable(ScriptedGrabber):
    """Nobody answers; a test tells when that is noticed."""

    def __init__(self):
        super().__init__()
        self.noticed_at_last = threading.Event()

    def open(self, access=Access.CONTROL):
        assert self.noticed_at_last.wait(PATIENCE)
        raise SourceNotFoundError("no camera answers at 10.0.0.9; check power, cable and address")


def test_a_wrong_address_is_reported_while_the_current_camera_continues(window_desk):
    window, link = window_desk.window, window_desk.program.connection
    window_desk.connect("sim:")
    window_desk.watch()
    shown, create, wrong = link.source, link._create, Unreachable()
    link._create = lambda uri: wrong if uri.scheme == "gige" else create(uri)
    window_desk.qtbot.keyClicks(window.sources.addressEdit, "gige:10.0.0.9")
    window_desk.qtbot.keyClick(window.sources.addressEdit, Qt.Key_Return)
    window_desk.until(lambda: window.picture.tasks.rows)
    assert window.picture.tasks.rows[0].textLabel.text() == "gige:10.0.0.9"
    window_desk.watch()
    wrong.noticed_at_last.set()
    window_desk.until(lambda: window_desk.errors)
    assert "no camera answers at 10.0.0.9" in window_desk.errors[0]
    window_desk.until(lambda: not window.picture.tasks.rows)
    assert link.source is shown and link.state is LinkState.STREAMING
    window_desk.watch()


def test_a_connection_that_takes_too_long_can_be_given_up(window_desk):
    window, link = window_desk.window, window_desk.program.connection
    window_desk.connect("sim:")
    shown, create, slow = link.source, link._create, Unreachable()
    link._create = lambda uri: slow if uri.scheme == "gige" else create(uri)
    window_desk.program.sources.connect_to("gige:10.0.0.9")
    window_desk.until(lambda: window.picture.tasks.rows)
    window_desk.qtbot.mouseClick(window.picture.tasks.rows[0].cancelButton, Qt.LeftButton)
    window_desk.until(lambda: not window.picture.tasks.rows)
    slow.noticed_at_last.set()
    assert link.pending is None and link.source is shown
    window_desk.watch()
    assert not window_desk.errors


def test_two_cameras_one_after_the_other_each_with_its_own_controls_and_image(window_desk):
    status, rows = window_desk.window.status, window_desk.window.favourites.rows
    for uri, pixel_format in (("sim:", "Mono8"), ("sim:?pixel_format=BayerRG8", "BayerRG8")):
        window_desk.connect(uri)
        window_desk.watch()
        window_desk.until(lambda name=pixel_format: status.formatLabel.text().endswith(name))
        window_desk.until(lambda: rows.rows("Gain") and rows.rows("Gain")[0].editor is not None)
    assert not window_desk.errors

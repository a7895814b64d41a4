"""The window as a person uses it, on the simulated camera."""

import os
import threading
from dataclasses import replace
from urllib.parse import quote

import cv2
import numpy as np
import pytest
from PyQt5.QtCore import Qt
from PyQt5.QtGui import QColor
from PyQt5.QtWidgets import QAbstractButton, QAction, QLineEdit, QToolButton

from every_case import every_case
from fakes import ScriptedGrabber
from grabbergui.core.errors import AccessDeniedError, SourceNotFoundError
from grabbergui.core.features import AccessMode, Feature, FeatureKind
from grabbergui.core.grabber import Access
from grabbergui.core.identity import DeviceInfo
from grabbergui.models.open_source import LinkState
from grabbergui.models.sources import ListedSource, takes_description
from grabbergui.models.unavailable import Unavailable
from grabbergui.ui import theme
from grabbergui.ui.editors.feature_editor import ReadingLabel
from grabbergui.ui.editors.number_editors import RangeEditor
from grabbergui.ui.theme import DARK, LIGHT
from grabbergui.ui.widgets.source_cards import SOURCE_ROLE
from grabbergui.ui.widgets.tinted import INK, PLATE, TINTS
from patience import PATIENCE, attempts


def test_the_image_arrives_and_the_state_reports_it(app):
    app.connect()
    app.watch()
    status = app.window.status
    app.until(lambda: "Live" in status.stateLabel.text() and "Mono8" in status.formatLabel.text())
    assert status.stateLabel.property("tone") == "good"
    app.until(lambda: float(status.rateLabel.text().split()[0]) > 5)
    assert "grabbergui" in app.window.windowTitle()
    assert not app.errors


def test_moving_a_slider_changes_the_cameras_register(app):
    app.connect()
    rows = app.window.favourites.rows
    app.until(lambda: rows.rows("ExposureTime") and rows.rows("ExposureTime")[0].editor is not None)
    slider = rows.rows("ExposureTime")[0].editor.slider()
    before = app.grabber.feature("ExposureTime").value
    app.until(slider.isEnabled)
    app.qtbot.keyClick(slider, Qt.Key_PageUp)
    app.until(lambda: app.grabber.feature("ExposureTime").value > before * 1.01)


def test_stop_and_start(app):
    window, link = app.window, app.program.opener
    app.connect()
    app.watch()
    window.actionStop.trigger()
    app.until(lambda: link.open_sources.state is LinkState.OPEN)
    app.until(lambda: "Stopped" in window.status.stateLabel.text())
    assert not app.grabber.streaming
    app.until(lambda: window.actionStart.isEnabled() and not window.actionStop.isEnabled())
    window.actionStart.trigger()
    app.until(lambda: link.open_sources.state is LinkState.STREAMING)
    app.watch()


def test_a_snapshot_holds_the_frames_own_pixels(app, tmp_path):
    app.connect()
    app.watch()
    app.window.actionStop.trigger()
    app.until(lambda: app.window.actionStart.isEnabled())
    app.window.actionSnapshot.trigger()
    app.until(lambda: any("Saved" in message for message in app.errors))
    (path,) = (tmp_path / "snapshots").glob("*.png")
    frame = app.program.image.frame
    assert np.array_equal(cv2.imread(str(path), cv2.IMREAD_UNCHANGED), frame.raw())


def test_a_refused_write_shows_in_the_error_bar_and_can_be_dismissed(app):
    app.connect()
    features = app.program.open_sources.current.features
    features.write("ExposureTime", -5.0)
    app.until(lambda: app.errors)
    assert "ExposureTime=-5: out of range" in app.errors[0]
    button = app.window.messages.closeButton
    app.until(button.isVisible)
    app.qtbot.mouseClick(button, Qt.LeftButton)
    assert not app.errors
    app.until(lambda: not app.window.messages.isVisible())
    app.watch()


@pytest.mark.parametrize(
    ("typed", "said"),
    [("sim:?widht=64", "did you mean width"), ("nonsense:1", "no known kind")],
)
def test_a_bad_address_is_explained(app, typed, said):
    edit = app.window.sources.addressEdit
    app.qtbot.keyClicks(edit, typed)
    app.qtbot.keyClick(edit, Qt.Key_Return)
    app.until(lambda: app.errors)
    assert said in app.errors[0]
    app.until(lambda: app.program.open_sources.state is LinkState.CLOSED)


def test_typing_an_address_connects_and_the_button_lets_go(app):
    view = app.window.sources
    app.qtbot.keyClicks(view.addressEdit, "sim:")
    app.qtbot.keyClick(view.addressEdit, Qt.Key_Return)
    app.until(lambda: app.program.open_sources.state is LinkState.STREAMING)
    app.until(lambda: view.connectButton.text() == "Disconnect")
    app.qtbot.mouseClick(view.connectButton, Qt.LeftButton)
    app.until(lambda: app.program.open_sources.state is LinkState.CLOSED)
    app.until(lambda: "Not connected" in app.window.status.stateLabel.text())
    assert not app.window.actionSnapshot.isEnabled()


def test_sources_found_are_listed_and_a_refresh_keeps_the_selection(app):
    view = app.window.sources
    one = ListedSource(DeviceInfo("gige:1", vendor="Acme", model="One", serial="1", address="10.0.0.1"))
    two = ListedSource(DeviceInfo("gige:2", vendor="Acme", model="Two", note="in another subnet"))
    view.setSources([one, two])
    view.sourceList.setCurrentRow(1)
    view.setSources([two, one])
    assert view.selected == "gige:2"
    with app.qtbot.waitSignal(view.connectRequested) as asked:
        app.qtbot.mouseClick(view.connectButton, Qt.LeftButton)
    assert asked.args == ["gige:2"]


def test_connecting_and_closing_twenty_times_leaves_no_thread(app):
    before = set(threading.enumerate())
    for _ in range(20):
        app.connect()
        app.program.open_sources.close_current()
    assert app.program.open_sources.wait_closed(PATIENCE)
    app.until(lambda: not set(threading.enumerate()) - before)


def test_closing_while_it_streams_and_searches_takes_less_than_a_second(make_app):
    for watch in attempts(1.0):
        app = make_app()
        app.program.begin("sim:")
        app.until(lambda app=app: app.program.open_sources.state is LinkState.STREAMING)
        with watch:
            app.window.close()


def test_closing_while_a_camera_does_not_answer_takes_little_more_than_a_second(make_app):
    answer = threading.Event()

    def create(uri):
        answer.wait(PATIENCE)
        raise SourceNotFoundError(f"{uri} does not answer")

    for watch in attempts(1.2):
        answer.clear()
        app = make_app()
        note = app.window.image.note
        app.program.opener.create = create
        app.program.begin("gige:10.255.255.1")
        app.until(lambda note=note: "Connecting" in note.summaryLabel.text())
        with watch:
            app.window.close()
        answer.set()


def test_every_control_has_a_name_to_be_read_aloud(app):
    for button in app.window.sources.findChildren(QAbstractButton):
        if isinstance(button.parent(), QLineEdit):
            continue  # Qt's own button that clears the field
        assert button.accessibleName() or button.text(), button.objectName()
    for edit in app.window.sources.findChildren(QLineEdit):
        assert edit.accessibleName() or edit.objectName() == "qt_spinbox_lineedit"
    for action in app.window.toolBar.actions():
        assert action.isSeparator() or (action.text() and not action.icon().isNull()), action.objectName()


def test_no_two_actions_share_a_shortcut(app):
    keys = [a.shortcut().toString() for a in app.window.findChildren(QAction) if not a.shortcut().isEmpty()]
    assert len(keys) == len(set(keys))


def luminance(colour):
    parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


@every_case("colours", [LIGHT, DARK])
@every_case(
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


@pytest.mark.parametrize("ink", [INK, *TINTS.values()], ids=["ink", *TINTS])
def test_numbers_over_a_white_image_can_be_read(ink):
    ground = QColor.fromRgb(*[255 - PLATE.alpha()] * 3)
    assert (luminance(ink.name()) + 0.05) / (luminance(ground.name()) + 0.05) >= 4.5, "WCAG 2.1, AA"


def test_the_look_can_be_changed_while_it_runs(app, qapp):
    before = qapp.palette(), qapp.styleSheet(), qapp.style().objectName()
    try:
        app.window.actionThemeDark.trigger()
        assert app.window.palette().window().color().name() == DARK.window
        app.window.actionThemeLight.trigger()
        assert app.window.palette().window().color().name() == LIGHT.window
        assert app.preferences.theme is theme.Theme.LIGHT
    finally:
        qapp.setStyle(before[2])
        qapp.setStyleSheet(before[1])
        qapp.setPalette(before[0])


class HeldElsewhere(ScriptedGrabber):
    """Another program has control until it releases it; read-only beside it, as GenICam cameras are."""

    held = True
    holder = "10.0.0.5"

    def open(self, access=Access.CONTROL):
        if self.held and access is not Access.MONITOR:
            text = f"another application at {self.holder} controls Acme Script; close it there"
            raise AccessDeniedError(text)
        super().open(access)

    def feature(self, name):
        feature = super().feature(name)
        return replace(feature, access=AccessMode.READ_ONLY) if self.access is Access.MONITOR else feature

    def start(self, *, keep_trigger=False):
        if self.access is Access.MONITOR:
            raise AccessDeniedError("the camera sends its images to 10.0.0.5")
        super().start()


def test_a_camera_held_by_another_program_can_be_looked_at_and_taken_over(app):
    gain = Feature(name="Gain", kind=FeatureKind.FLOAT, access=AccessMode.READ_WRITE, value=3.0, minimum=0.0,
                   maximum=24.0)  # fmt: skip
    reset = Feature(name="Reset", kind=FeatureKind.COMMAND, access=AccessMode.WRITE_ONLY, category="Other")
    grabber = HeldElsewhere([gain, reset])
    link, window = app.program.opener, app.window
    link.create = lambda uri: grabber
    app.program.source_controls.sources.connect_to("fake:")
    app.until(lambda: app.errors)
    assert "read only: another application at 10.0.0.5" in app.errors[0]
    rows = window.favourites.rows
    app.until(lambda: rows.rows("Gain") and rows.rows("Gain")[0].editor is not None)
    assert isinstance(rows.rows("Gain")[0].editor, ReadingLabel)
    window.features.filterEdit.setText("reset")
    panel = window.features.rows
    app.until(lambda: panel.rows("Reset") and panel.rows("Reset")[0].editor is not None)
    assert not panel.rows("Reset")[0].editor.isEnabled(), "nor is a command"
    app.until(lambda: "goes to the program" in window.image.note.summaryLabel.text())
    assert "✗ control" in window.image.note.stageLabel.text(), "it was passed, as if this program had it"
    assert not window.actionStart.isEnabled(), "it had no effect"
    assert "10.0.0.5" in window.actionStart.toolTip()
    assert "Read only" in window.status.stateLabel.text()

    button = window.messages.findChild(QAbstractButton, "offerButton")
    assert button.isVisible() and button.text() == "Take control"
    app.qtbot.mouseClick(button, Qt.LeftButton)  # still held
    agree(app)
    app.until(lambda: link.open_sources.state is LinkState.OPEN and len(app.errors) == 1)
    grabber.held = False
    app.until(lambda: window.messages.findChildren(QAbstractButton, "offerButton"))
    button = window.messages.findChildren(QAbstractButton, "offerButton")[-1]
    app.qtbot.mouseClick(button, Qt.LeftButton)
    agree(app)
    app.until(lambda: link.open_sources.state is LinkState.STREAMING and not app.errors)
    app.until(lambda: rows.rows("Gain") and isinstance(rows.rows("Gain")[0].editor, RangeEditor))


def agree(app, button="Take control"):
    app.until(lambda: app.program.source_controls.sources.question is not None)
    buttons = app.program.source_controls.sources.question.buttons()
    next(each for each in buttons if each.text() == button).click()
    app.until(lambda: app.program.source_controls.sources.question is None)


def test_take_control_asks_first_and_names_program_and_recording(app, tmp_path):
    """One click ended the other program's recording."""
    grabber, link = HeldElsewhere([]), app.program.opener
    grabber.holder = f"127.0.0.1 (recorder, PID {os.getpid()})"
    link.create = lambda uri: grabber
    app.program.source_controls.sources.connect_to("fake:")
    app.until(lambda: app.window.messages.findChildren(QAbstractButton, "offerButton"))
    before = link.open_sources.current
    with (tmp_path / "day 1.mcap").open("wb"):
        app.qtbot.mouseClick(
            app.window.messages.findChildren(QAbstractButton, "offerButton")[-1], Qt.LeftButton
        )
        app.until(lambda: app.program.source_controls.sources.question is not None)
    question = app.program.source_controls.sources.question
    assert f"from recorder, PID {os.getpid()}?" in question.text()
    assert question.informativeText() == "It is recording day 1.mcap; the recording ends."
    agree(app, "Leave it there")
    assert link.open_sources.current is before and grabber.held


def test_take_control_answers_every_time(app):
    gain = Feature(name="Gain", kind=FeatureKind.FLOAT, access=AccessMode.READ_WRITE, value=3.0, minimum=0.0,
                   maximum=24.0)  # fmt: skip
    grabber, link = HeldElsewhere([gain]), app.program.opener
    link.create = lambda uri: grabber
    app.program.source_controls.sources.connect_to("fake:")

    def offered():
        buttons = app.window.messages.findChildren(QAbstractButton, "offerButton")
        return next((button for button in buttons if button.isVisible()), None)

    app.until(lambda: app.errors and offered())
    assert app.errors[0].startswith("read only")
    for _ in range(2):
        before = link.open_sources.current
        app.qtbot.mouseClick(offered(), Qt.LeftButton)
        agree(app)
        app.until(lambda before=before: link.open_sources.current not in (before, None) and app.errors)
        app.until(lambda: app.errors[0].startswith("control was not given") and offered())
        assert len(app.errors) == 1


def test_a_source_opened_by_its_address_is_listed_as_connected_and_remembered(app):
    view = app.window.sources
    app.qtbot.keyClicks(view.addressEdit, "sim:?pixel_format=Mono12p")
    app.qtbot.keyClick(view.addressEdit, Qt.Key_Return)
    app.until(lambda: app.program.open_sources.state is LinkState.STREAMING)
    app.until(lambda: view.sourceList.item(0).data(SOURCE_ROLE).connected)
    assert view.sourceList.count() == 1
    line = view.sourceList.item(0).data(SOURCE_ROLE)
    assert line.connected and line.manual and line.info.model == "Simulated camera"
    assert app.preferences.typed == ["sim:?pixel_format=Mono12p"]
    app.program.open_sources.close_current()
    app.until(lambda: not view.sourceList.item(0).data(SOURCE_ROLE).connected)
    view.forgetRequested.emit(line.info.uri)
    app.until(lambda: view.sourceList.count() == 0)
    assert app.preferences.typed == []


def test_a_camera_is_opened_with_a_description_from_a_file(app, monkeypatch, tmp_path):
    file, opened = tmp_path / "model.xml", []
    sources = app.program.source_controls.sources
    monkeypatch.setattr(app.program.files, "to_open", lambda title, kinds: file, raising=False)
    monkeypatch.setattr(sources, "connect_to", opened.append)
    app.window.sources.descriptionRequested.emit("gige:40012345?resend=0")
    assert opened == [f"gige:40012345?resend=0&description={quote(str(file), safe='')}"]
    monkeypatch.setattr(app.program.files, "to_open", lambda title, kinds: None, raising=False)
    app.window.sources.descriptionRequested.emit("gige:40012345")
    assert len(opened) == 1


@pytest.mark.parametrize(
    ("uri", "takes"), [("gige:1", True), ("u3v:", True), ("sim:", False), ("yarp:/a", False)]
)
def test_only_genicam_cameras_take_a_description(uri, takes):
    assert takes_description(uri) is takes


class Unreachable(ScriptedGrabber):
    """Nobody answers; the test decides when that is noticed."""

    def __init__(self):
        super().__init__()
        self.noticed_at_last = threading.Event()

    def open(self, access=Access.CONTROL):
        assert self.noticed_at_last.wait(PATIENCE)
        raise SourceNotFoundError("no camera answers at 10.0.0.9; check power, cable and address")


def test_a_wrong_address_is_reported_while_the_current_camera_continues(app):
    window, link = app.window, app.program.opener
    app.connect()
    app.watch()
    shown, create, wrong = link.open_sources.current, link.create, Unreachable()
    link.create = lambda uri: wrong if uri.scheme == "gige" else create(uri)
    app.qtbot.keyClicks(window.sources.addressEdit, "gige:10.0.0.9")
    app.qtbot.keyClick(window.sources.addressEdit, Qt.Key_Return)
    app.until(lambda: window.image.tasks.rows)
    assert window.image.tasks.rows[0].textLabel.text() == "gige:10.0.0.9"
    app.watch()
    wrong.noticed_at_last.set()
    app.until(lambda: app.errors)
    assert "no camera answers at 10.0.0.9" in app.errors[0]
    app.until(lambda: not window.image.tasks.rows)
    assert link.open_sources.current is shown and link.open_sources.state is LinkState.STREAMING
    app.watch()


def test_a_connection_that_takes_too_long_can_be_given_up(app):
    window, link = app.window, app.program.opener
    app.connect()
    shown, create, slow = link.open_sources.current, link.create, Unreachable()
    link.create = lambda uri: slow if uri.scheme == "gige" else create(uri)
    app.program.source_controls.sources.connect_to("gige:10.0.0.9")
    app.until(lambda: window.image.tasks.rows)
    app.qtbot.mouseClick(window.image.tasks.rows[0].cancelButton, Qt.LeftButton)
    app.until(lambda: not window.image.tasks.rows)
    slow.noticed_at_last.set()
    assert link.open_sources.pending is None and link.open_sources.current is shown
    app.watch()
    assert not app.errors


def test_two_cameras_one_after_the_other_each_with_its_own_controls_and_image(app):
    status, rows = app.window.status, app.window.favourites.rows
    for uri, pixel_format in (("sim:", "Mono8"), ("sim:?pixel_format=BayerRG8", "BayerRG8")):
        app.connect(uri)
        app.watch()
        app.until(lambda name=pixel_format: status.formatLabel.text().endswith(name))
        app.until(lambda: rows.rows("Gain") and rows.rows("Gain")[0].editor is not None)
    assert not app.errors


def test_each_action_and_button_that_is_not_available_gives_the_reason(app):
    window, link = app.window, app.program.opener
    reasons = [reason.text for reason in Unavailable]

    def unexplained():
        """Names of what is disabled for no reason; a feature's own row explains itself."""
        actions = [action for action in window.findChildren(QAction) if action.text()]
        buttons = [
            button
            for button in window.findChildren(QAbstractButton)
            if button.objectName() and button.isVisibleTo(window) and not isinstance(button, QToolButton)
        ]
        return [
            control.objectName() or control.text()
            for control in (*actions, *buttons)
            if not control.isEnabled() and not control.toolTip().endswith(tuple(reasons))
        ]

    assert not unexplained()
    assert window.actionStart.toolTip() == f"Start streaming (F6)\n{Unavailable.SOURCE.text}"
    app.connect()
    app.until(lambda: window.actionExpose.isEnabled() and window.actionUserSets.isEnabled())
    assert not unexplained()
    assert window.actionStart.toolTip().endswith(Unavailable.REST.text)
    assert window.actionUndo.toolTip().endswith(Unavailable.CHANGE.text)
    link.stream.stop()
    app.until(window.actionStart.isEnabled)
    assert not unexplained()
    assert window.actionStart.toolTip() == "Start streaming (F6)"
    assert window.recordingBar.recordButton.toolTip().endswith(Unavailable.STREAM.text)
    assert window.actionExpose.toolTip().endswith(Unavailable.STREAM.text)

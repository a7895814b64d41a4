"""Controllers know small views only: they work without the main window."""

import ast
from pathlib import Path
from types import SimpleNamespace

import pytest
from PyQt5.QtCore import QObject
from PyQt5.QtWidgets import QAction, QWidget

import grabbergui.ui.controllers
from grabbergui.models.frame_history import FrameHistory
from grabbergui.models.image.live_image import ImageModel
from grabbergui.models.messages import MessageModel, Severity
from grabbergui.models.open_sources import OpenSources
from grabbergui.models.source_messages import CurrentMessages
from grabbergui.ui.controllers.calibration import CalibrationViewController
from grabbergui.ui.controllers.recording import PauseController
from grabbergui.ui.controllers.source_context import SourceContext
from grabbergui.ui.controllers.tuning import RegionController
from grabbergui.ui.preferences import Preferences
from grabbergui.ui.views.recording_bars import PauseBar
from grabbergui.ui.widgets.drawing_tool import DrawingTool
from grabbergui.ui.widgets.image_canvas import ImageCanvas
from grabbergui.ui.widgets.region_tool import RegionTool

PACKAGE = Path(grabbergui.ui.controllers.__file__).parent


class Painted(QObject):
    """An image that is never painted."""

    def __init__(self):
        super().__init__()
        self.painted = self.destroyed


class NoFiles:
    """Questions for files, all of them cancelled."""

    def __init__(self, answer=None):
        self.answer, self.asked = answer, []

    def to_open(self, title, kinds, folder=None):
        self.asked.append(title)
        return self.answer


@pytest.fixture
def program(qapp):
    """The models that any controller gets."""
    owner, messages, files = QWidget(), MessageModel(), NoFiles()
    open_sources = OpenSources(messages)
    current = CurrentMessages(messages, lambda: open_sources.current)
    context = SourceContext(open_sources, ImageModel(), current, Preferences(None), files, owner)
    yield SimpleNamespace(owner=owner, messages=messages, files=files, context=context)
    owner.deleteLater()
    qapp.processEvents()


def actions(owner, *names):
    made = {name: QAction(owner) for name in names}
    for action in made.values():
        action.setCheckable(True)
    return SimpleNamespace(**made)


def test_a_pause_without_frames_says_why_and_is_over(program, qtbot):
    buttons = actions(program.owner, "actionPause", "actionStepBack", "actionStepForward")
    bar = PauseBar()
    qtbot.addWidget(bar)
    controller = PauseController(buttons, bar, program.context, FrameHistory())

    buttons.actionPause.setChecked(True)

    assert controller.parent() is program.owner
    assert not buttons.actionPause.isChecked() and bar.isHidden()
    (message,) = program.messages.shown(None)
    assert message.severity is Severity.ERROR and "no frame yet" in message.text


class Undrawn:
    """An image whose drawing tool counts how often it was asked for."""

    def __init__(self, qtbot):
        self.purposes = []
        self.canvas = ImageCanvas()
        qtbot.addWidget(self.canvas)
        self.drawing = DrawingTool(self.canvas)
        self.regionTool = RegionTool(self.canvas)
        self.painted = self.canvas.painted

    def draw(self, purpose):
        self.purposes.append(purpose)


def test_a_region_cannot_be_drawn_where_there_is_no_image(program, qtbot):
    buttons, view = actions(program.owner, "actionRegion", "actionFullSensor"), Undrawn(qtbot)
    RegionController(buttons, view, program.context)
    buttons.actionRegion.setEnabled(True)

    buttons.actionRegion.trigger()

    assert not view.purposes
    (message,) = program.messages.shown(None)
    assert "no image" in message.text and "OffsetX" in message.text


def test_loading_a_calibration_that_is_cancelled_does_nothing(program):
    buttons = actions(program.owner, "actionLoadCalibration", "actionShowCalibration")
    CalibrationViewController(buttons, program.context)

    assert not buttons.actionLoadCalibration.isEnabled()  # there is no camera
    buttons.actionLoadCalibration.setEnabled(True)
    buttons.actionLoadCalibration.trigger()

    assert program.files.asked and not program.messages.shown(None)
    assert program.context.image.settings.calibration is None


def test_no_controller_takes_the_main_window():
    for path in PACKAGE.glob("*.py"):
        imported = [
            node.module
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
            if isinstance(node, ast.ImportFrom)
        ]
        assert "grabbergui.ui.views.main_window" not in imported, path.name

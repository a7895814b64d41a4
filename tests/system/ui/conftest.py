"""The whole window on the simulated camera, offscreen, remembering nothing."""

import threading
import time

import pytest
from PyQt5.QtWidgets import QApplication

from grabbergui.models.open_source import LinkState
from grabbergui.ui.preferences import Preferences
from grabbergui.ui.run.program import Program
from grabbergui.ui.views.main_window import MainWindow
from panels import make_panel  # noqa: F401
from patience import PATIENCE


class App:
    """A window and the program behind it, with the steps that tests repeat."""

    def __init__(self, qtbot, snapshots):
        self.qtbot = qtbot
        self.preferences = Preferences(None)
        self.preferences.snapshot_folder = snapshots
        self.window = MainWindow()
        self.window.resize(1280, 800)
        self.program = Program(self.window, self.preferences)
        qtbot.addWidget(self.window)
        self.window.show()

    @property
    def errors(self):
        """Return the messages about the current camera, the newest first."""
        program = self.program
        return [message.text for message in program.messages.shown(program.open_sources.current)]

    @property
    def grabber(self):
        return self.program.open_sources.current.grabber

    def connect(self, uri="sim:?fps=15"):
        link = self.program.opener
        before = link.open_sources.current
        self.program.source_controls.sources.connect_to(uri)
        self.until(
            lambda: link.open_sources.current is not before and link.open_sources.state is LinkState.STREAMING
        )
        # The window hears of it later, perhaps much later on a busy machine; until then its buttons are off.
        self.until(self.window.recordingBar.recordButton.isEnabled)
        QApplication.processEvents()

    def watch(self, images=3):
        """Wait until so many more images are painted."""
        painted = []
        self.window.image.painted.connect(lambda: painted.append(1))
        self.until(lambda: len(painted) >= images)

    def until(self, condition, seconds=PATIENCE):
        self.qtbot.waitUntil(lambda: bool(condition()), timeout=int(1000 * seconds))

    def wait_for_cards(self, count):
        """Wait until so many controls stand above the image, each with its editor, which makes it higher."""
        strip = self.window.favourites
        self.until(
            lambda: (
                len(strip.shownCards) == count and all(card.editor is not None for card in strip.shownCards)
            )
        )

    def settled(self, look):
        """Return what a look finds once all looks of a fifth of a second, three at least, find the same."""
        found, since = [], time.monotonic()

        def settled():
            nonlocal since
            found.append(look())
            if found[-2:-1] != found[-1:]:
                since = time.monotonic()
            return found[-3:] == 3 * found[-1:] and time.monotonic() - since >= 0.2

        self.until(settled)
        return found[-1]


@pytest.fixture
def make_app(qtbot, tmp_path):
    """Makes applications, each with a window of its own."""
    before = set(threading.enumerate())
    made = []

    def make():
        made.append(App(qtbot, tmp_path / "snapshots"))
        return made[-1]

    yield make
    for app in made:
        app.window.close()
        assert not app.program.shut_down(PATIENCE)
    # A measurement that is under way on a busy machine may end a little later; a leak never does.
    for thread in set(threading.enumerate()) - before:
        thread.join(PATIENCE)
    left = [thread.name for thread in threading.enumerate() if thread not in before]
    assert not left, f"threads left behind: {left}"


@pytest.fixture
def app(make_app):
    return make_app()

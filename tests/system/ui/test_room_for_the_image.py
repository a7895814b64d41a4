"""The share of the window that the image itself covers, without the black beside it."""

import pytest
from PyQt5.QtCore import QRect
from PyQt5.QtGui import QKeySequence
from PyQt5.QtWidgets import QAction

from grabbergui.ui.editors.feature_row import LEAST_SLIDER
from grabbergui.ui.interface_language import speak
from grabbergui.ui.theme import Theme, dress

FULL_HD, LAPTOP, SMALL, NETBOOK = (1920, 1080), (1366, 768), (1280, 800), (1024, 600)
FOUR_TO_THREE, SIXTEEN_TO_NINE = "width=64&height=48", "width=64&height=36"


@pytest.fixture(autouse=True)
def styled(qapp, request):
    """Fonts and margins are those of the program."""
    request.addfinalizer(lambda: (qapp.setStyleSheet(""), speak(qapp, "en")))
    dress(qapp, Theme.LIGHT)


def window_of(make_app, qapp, size, cameras, histogram, language):
    speak(qapp, language)
    app = make_app()
    app.window.resize(*size)
    app.connect(f"sim:?{cameras[0]}&fps=15")
    for index, camera in enumerate(cameras[1:], 1):
        app.program.opener.open_additional(f"sim:?{camera}&fps={15 - index}")
    app.until(lambda: len(app.program.open_sources.all) == len(cameras))
    if histogram:
        panel(app, "F2").trigger()
        app.until(lambda: not app.window.histogramDock.visibleRegion().isEmpty())
    app.wait_for_cards(3)
    return app


def panel(app, key):
    return next(a for a in app.window.findChildren(QAction) if a.shortcut() == QKeySequence(key))


def share(app):
    """Return the share of the window's pixels that show the current camera's image."""
    canvas, window = app.window.image.canvas, app.window
    first, last = canvas.frameToView(0, 0).toPoint(), canvas.frameToView(*canvas.imageSize).toPoint()
    shown = QRect(first, last).intersected(canvas.rect())
    return shown.width() * shown.height() / (window.width() * window.height())


@pytest.mark.parametrize(
    ("size", "cameras", "histogram", "least", "language"),
    [
        (FULL_HD, [FOUR_TO_THREE], False, 0.60, "en"),
        (FULL_HD, [SIXTEEN_TO_NINE], False, 0.60, "en"),
        (FULL_HD, 4 * [FOUR_TO_THREE], True, 0.45, "en"),
        (LAPTOP, 2 * [FOUR_TO_THREE], True, 0.40, "en"),
        (LAPTOP, 2 * [SIXTEEN_TO_NINE], True, 0.40, "es"),
        (NETBOOK, [FOUR_TO_THREE], True, 0.30, "en"),
        (NETBOOK, [FOUR_TO_THREE], True, 0.30, "es"),
    ],
)  # fmt: skip
def test_the_image_itself_covers_most_of_the_window(
    make_app, qapp, size, cameras, histogram, least, language
):
    app = window_of(make_app, qapp, size, cameras, histogram, language)
    assert app.settled(lambda: round(share(app), 3)) >= least
    assert (app.window.width(), app.window.height()) == size


@pytest.mark.parametrize("size", [FULL_HD, LAPTOP, NETBOOK])
def test_controls_of_every_minute_are_seen_beside_it(make_app, qapp, size):
    app = window_of(make_app, qapp, size, [FOUR_TO_THREE], True, "en")
    window = app.window
    buttons = [window.toolBar.widgetForAction(action) for action in (
        window.actionStart, window.actionStop, window.actionPause, window.actionSnapshot)]  # fmt: skip
    for control in (*buttons, window.recordingBar.recordButton, window.recordingBar.kindBox,
                    *window.favourites.shownCards):  # fmt: skip
        app.until(lambda control=control: control.visibleRegion().boundingRect() == control.rect())
    assert window.sources.addressEdit.isVisible(), "in front, or a tab beside the features"


@pytest.mark.parametrize(("size", "language"), [(LAPTOP, "es"), (SMALL, "en"), (SMALL, "es")])
def test_exposure_gain_and_rate_share_one_line(make_app, qapp, size, language):
    app = window_of(make_app, qapp, size, [FOUR_TO_THREE], False, language)
    cards = app.window.favourites.shownCards
    app.until(lambda: [card.auto is not None for card in cards] == [True, True, False])
    sliders = [card.editor.slider() for card in cards]
    assert len(app.settled(lambda: {card.y() for card in cards})) == 1

    def alike():
        widths = [slider.width() for slider in sliders]
        return LEAST_SLIDER <= min(widths) <= max(widths) < 2 * min(widths)

    app.until(alike)

"""Messages and work in progress in the window: they move nothing, can be read in full, and take no keys."""

import itertools

import pytest
from PyQt5.QtCore import QPoint, Qt
from PyQt5.QtWidgets import QApplication, QScrollArea, QToolButton

from grabbergui.models.messages import Offer, Severity, UserMessage
from grabbergui.ui.tab_order import reading_order
from grabbergui.ui.theme import DARK, LIGHT, Theme, dress
from grabbergui.ui.widgets.message_line import MessageLine
from grabbergui.ui.widgets.messages import MessageBar


def test_the_image_stays_where_it_is_under_a_message(app):
    window = app.window
    app.connect()
    app.watch()
    # The bar above the image is as high as its controls, which arrive one by one.
    app.wait_for_cards(3)
    before = app.settled(lambda: (window.image.geometry(), window.statusbar.geometry()))
    for text in ("saved " * 40, "no space left on the disk"):
        app.program.messages.error(text)
        app.until(lambda text=text: text in window.messages.messages)
    assert window.messages.isVisible() and (window.image.geometry(), window.statusbar.geometry()) == before
    corner = window.messages.mapTo(window, QPoint(0, 0)).y()
    assert corner > window.recordingBar.mapTo(window, QPoint(0, 0)).y(), "it lies over nothing"


@pytest.mark.parametrize("streaming", [False, True], ids=["note", "image"])
def test_the_image_stays_where_it_is_under_work_in_progress(app, streaming):
    window, image = app.window, app.window.image
    if streaming:
        app.connect()
        app.watch()
        # The bar above the image is as high as its controls, which arrive one by one.
        app.wait_for_cards(3)

    def places():
        # A note that is not needed keeps the place that it had last, until it is shown again.
        return image.canvas.geometry(), None if streaming else (image.note.isVisible(), image.note.geometry())

    before = app.settled(places)
    rows = [image.tasks.begin(title) for title in ("Connecting", "Loading settings")]
    rows[0].setText("a long name " * 30)
    for size in ((1280, 800), (800, 600)):
        window.resize(*size)
        app.until(lambda size=size: (window.width(), window.height()) == size)
        app.until(lambda: image.canvas.geometry().contains(image.tasks.geometry()))
        app.until(lambda: rows[0].geometry().bottom() < rows[1].y())
        app.until(lambda: all(row.height() >= row.minimumSizeHint().height() for row in rows))
        assert all(not row.cancelButton.visibleRegion().isEmpty() for row in rows)
    window.resize(1280, 800)
    app.until(lambda: places() == before)
    for row in rows:
        image.tasks.end(row)
    assert not image.tasks.isVisible() and places() == before


def test_a_message_that_does_not_fit_and_those_behind_it_can_be_read_in_full(app):
    window, messages = app.window, app.program.messages
    messages.error("a first failure")
    messages.error("a long one " * 30)
    app.until(lambda: len(window.messages.messages) == 2)
    assert window.messages.moreButton.text() == "1 more"
    app.qtbot.mouseClick(window.messages.moreButton, Qt.LeftButton)
    bars = window.messages._popup.findChildren(MessageBar)
    assert [bar.textLabel.text().strip() for bar in bars] == [("A long one " + "a long one " * 29).strip(),
                                                             "A first failure"]  # fmt: skip
    label = bars[0].textLabel
    app.until(lambda: label.height() >= label.heightForWidth(label.width()))
    assert not reading_order(bars), "the keyboard lands on no cross here either"
    app.qtbot.mouseClick(bars[0].closeButton, Qt.LeftButton)
    app.until(lambda: window.messages.messages == ["a first failure"])
    assert not window.messages.moreButton.isVisible(), "all of it is to be seen"


@pytest.mark.parametrize("count", [3, 30])
def test_the_list_of_messages_stays_on_the_screen_and_scrolls_where_it_must(app, count):
    window, messages = app.window, app.program.messages
    window.resize(780, 560)
    app.until(lambda: window.height() == 560)
    for number in range(count):
        messages.error(f"failure {number}: the camera refused the value")
    app.until(lambda: len(window.messages.messages) > 2)
    window.messages.showAll()
    popup = window.messages._popup
    assert window.screen().availableGeometry().contains(popup.geometry())
    bars, area = popup.findChildren(MessageBar), popup.findChild(QScrollArea)
    app.until(lambda: bars[0].visibleRegion().boundingRect() == bars[0].rect())
    area.ensureWidgetVisible(bars[-1])
    app.until(lambda: bars[-1].visibleRegion().boundingRect() == bars[-1].rect())
    assert area.verticalScrollBar().isVisible() == (count == 30)
    assert bars[0].height() < 2 * bars[0].textLabel.fontMetrics().height() + 20
    popup.close()


def test_another_theme_also_changes_the_icon_of_a_message_and_what_is_around_the_image(app, qapp, request):
    request.addfinalizer(lambda: qapp.setStyleSheet(""))
    messages, canvas = app.window.messages, app.window.image.canvas
    dress(qapp, Theme.LIGHT)
    app.program.messages.error("a failure")
    app.until(lambda: messages.messages)

    def brightest():
        image = messages.iconLabel.pixmap().toImage()
        places = itertools.product(range(image.width()), range(image.height()))
        solid = [image.pixelColor(*place) for place in places if image.pixelColor(*place).alpha() == 255]
        return max(colour.lightness() for colour in solid)

    assert brightest() < 128
    assert canvas.grab().toImage().pixelColor(5, 5).name() == LIGHT.canvas
    dress(qapp, Theme.DARK)
    app.until(lambda: brightest() > 128)
    assert canvas.grab().toImage().pixelColor(5, 5).name() == DARK.canvas
    dress(qapp, Theme.LIGHT)


def test_the_keys_of_the_window_work_while_the_list_of_messages_is_open(app):
    window, closed = app.window, []
    window.closing.connect(lambda: closed.append(True))
    app.connect()
    app.program.messages.error("a failure " * 30)
    app.until(lambda: window.messages.messages and window.actionStop.isEnabled())

    def press(*key):
        window.messages.showAll()
        popup = QApplication.activePopupWidget()
        app.qtbot.keyClick(popup, Qt.Key_Shift)
        assert QApplication.activePopupWidget() is popup
        app.qtbot.keyClick(popup, *key)
        assert QApplication.activePopupWidget() is None

    press(Qt.Key_F7)
    app.until(lambda: window.actionStart.isEnabled())
    press(Qt.Key_Q, Qt.ControlModifier)
    assert closed


def test_ctrl_q_ends_the_program_from_a_window_beside_the_main_window(app):
    closed = []
    app.window.closing.connect(lambda: closed.append(True))
    app.window.actionShowPoints.trigger()
    app.qtbot.keyClick(app.program.image_controls.points.dialog, Qt.Key_Q, Qt.ControlModifier)
    app.until(lambda: closed)


def test_the_keyboard_never_lands_on_a_cross_but_reaches_what_a_message_offers(app):
    window, pressed = app.window, []
    offers = (Offer("Do it", lambda: pressed.append(1)),)
    app.program.messages.post(UserMessage("it can be done", Severity.WARNING, offers=offers))
    app.until(lambda: window.messages.messages)
    reached = reading_order([window.messages])
    assert [button.text() for button in reached] == ["Do it"]
    app.qtbot.keyClick(reached[0], Qt.Key_Space)
    assert pressed == [1]
    app.qtbot.mouseClick(window.messages.closeButton, Qt.LeftButton)
    app.until(lambda: not window.messages.messages)
    assert not isinstance(QApplication.focusWidget(), QToolButton)


def test_a_line_that_is_cut_shows_the_cause(qtbot):
    line = MessageLine()
    qtbot.addWidget(line)
    line.resize(360, 30)
    text = "/home/user/pictures/of/the/left/camera/image_000123.tiff could not be written: the disk is full"
    line.setMessages([UserMessage(text, Severity.ERROR)])
    line.show()
    assert line.textLabel.shown.startswith("The disk is full: ")
    line.resize(2000, 30)
    assert line.textLabel.shown == text

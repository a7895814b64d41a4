"""Pinned controls: dragged to the top, put in order, removed, and remembered for each model of camera."""

import pytest
from PyQt5.QtCore import QEvent, QPoint, QSettings, Qt
from PyQt5.QtGui import QDrag, QDragEnterEvent, QDragMoveEvent, QDropEvent, QMouseEvent
from PyQt5.QtWidgets import QApplication

from feature_menus import choose_from_menu, menu_of
from grabbergui.core.features import FeatureDescription, FeatureKind
from grabbergui.core.identity import DeviceInfo
from grabbergui.models.features.pinned import MOST_PINNED, moved, placed, without
from grabbergui.models.unavailable import Unavailable
from grabbergui.ui.editors.feature_row import CARD_WIDTH
from grabbergui.ui.preferences import Preferences, camera_model
from grabbergui.ui.views.favourites import LINE_HEIGHT, FavouritesStrip

USUAL = ("ExposureTime", "Gain", "AcquisitionFrameRate")


@pytest.mark.parametrize(
    ("name", "index", "order"),
    [("D", 0, "DABC"), ("D", 1, "ADBC"), ("D", 9, "ABCD"), ("D", -4, "DABC"),
     ("A", 2, "BAC"), ("A", 3, "BCA"), ("A", 0, "ABC"), ("A", 1, "ABC"), ("C", 0, "CAB"), ("B", 3, "ACB")],
)  # fmt: skip
def test_a_name_is_placed_before_the_one_it_was_dropped_on(name, index, order):
    assert placed(tuple("ABC"), name, index) == tuple(order)


def test_names_are_moved_and_removed():
    assert moved(tuple("ABC"), "A", 1) == tuple("BAC")
    assert moved(tuple("ABC"), "A", -1) == tuple("ABC")
    assert moved(tuple("ABC"), "X", 1) == tuple("ABC")
    assert without(tuple("ABC"), "B") == tuple("AC")
    full = tuple(f"F{n}" for n in range(MOST_PINNED))
    assert placed(full, "X", 0) == full
    assert placed(full, "F3", 0)[0] == "F3"


@pytest.fixture
def app(make_app):
    app = make_app()
    app.connect("sim:?width=320&height=240&fps=15")
    strip = app.window.favourites
    app.wait_for_cards(3)
    app.until(lambda: len({(card.x(), card.y()) for card in strip.shownCards}) == 3)  # they have their places
    app.until(lambda: all(strip.rect().contains(card.geometry()) for card in strip.shownCards))
    app.settled(lambda: [card.geometry() for card in strip.shownCards])
    return app


def pinned(app):
    """Names of the cards as they stand, line by line."""
    strip = app.window.favourites
    cards = sorted(strip.shownCards, key=lambda card: (card.y(), card.x()))
    return tuple(card.name for card in cards)


def row(app, name):
    rows = app.window.features.rows
    app.until(lambda: rows.rows(name) and rows.rows(name)[0].isVisible())
    return rows.rows(name)[0]


def drag(app, monkeypatch, source, where):
    """Press the mouse on a row's name, move it, and release it over the strip."""
    strip = app.window.favourites

    def fly(flying, *_):
        data, button = flying.mimeData(), Qt.LeftButton
        for kind in (QDragEnterEvent, QDragMoveEvent):
            event = kind(where, Qt.CopyAction, data, button, Qt.NoModifier)
            QApplication.sendEvent(strip, event)
            assert event.isAccepted()
        assert strip._place is not None
        strip.grab()
        QApplication.sendEvent(strip, QDropEvent(where, Qt.CopyAction, data, button, Qt.NoModifier))
        return Qt.CopyAction

    monkeypatch.setattr(QDrag, "exec_", fly)
    label = source._label
    start = label.rect().center()
    before = app.program.feature_controls.favourites.names
    app.qtbot.mousePress(label, Qt.LeftButton, pos=start)
    for way in (QPoint(3, 0), QPoint(QApplication.startDragDistance(), 0)):
        assert app.program.feature_controls.favourites.names == before
        # Not over qtbot, whose moves have no button down.
        event = QMouseEvent(QEvent.MouseMove, start + way, Qt.NoButton, Qt.LeftButton, Qt.NoModifier)
        QApplication.sendEvent(label, event)


def test_a_control_is_dragged_among_the_favourites_and_works_there(app, monkeypatch):
    assert pinned(app) == USUAL
    second = app.window.favourites.shownCards[1].geometry()
    drag(app, monkeypatch, row(app, "AcquisitionBurstFrameCount"), second.center() - QPoint(40, 0))
    app.until(lambda: pinned(app) == ("ExposureTime", "AcquisitionBurstFrameCount", *USUAL[1:]))
    rows = app.window.favourites.rows
    app.until(lambda: all(rows.rows(name)[0].editor is not None for name in pinned(app)))
    field = rows.rows("AcquisitionBurstFrameCount")[0].editor.field
    app.until(field.isEnabled)
    field.setFocus()
    field.selectAll()
    app.qtbot.keyClicks(field, "3")
    app.qtbot.keyClick(field, Qt.Key_Return)
    app.until(lambda: app.grabber.feature("AcquisitionBurstFrameCount").value == 3)
    app.grabber.write_feature("AcquisitionBurstFrameCount", 5)
    app.until(lambda: field.text() == "5")


def test_favourites_are_put_in_another_order_by_dragging(app, monkeypatch):
    first, _, last = app.window.favourites.shownCards
    drag(app, monkeypatch, first, last.geometry().center() + QPoint(40, 0))
    app.until(lambda: pinned(app) == ("Gain", "AcquisitionFrameRate", "ExposureTime"))


def test_a_click_on_a_name_drags_nothing(app):
    label = app.window.favourites.shownCards[0]._label
    app.qtbot.mouseClick(label, Qt.LeftButton)
    assert pinned(app) == USUAL


def test_from_the_menu_they_are_added_moved_removed_and_the_usual_ones_come_back(app):
    choose_from_menu(app, row(app, "TriggerMode"), "Pin")
    app.until(lambda: pinned(app) == (*USUAL, "TriggerMode"))
    menu = menu_of(app, app.window.favourites.shownCards[3])
    (to_right,) = (action for action in menu.actions() if "right" in action.text().replace("&", ""))
    assert not to_right.isEnabled() and menu.toolTipsVisible()
    assert to_right.toolTip() == f"Move to the right\n{Unavailable.LAST.text}"
    menu.close()
    app.until(lambda: app.program.feature_controls.feature_menu.menu is None)
    choose_from_menu(app, app.window.favourites.shownCards[3], "Move to the left")
    app.until(lambda: pinned(app) == ("ExposureTime", "Gain", "TriggerMode", "AcquisitionFrameRate"))
    choose_from_menu(app, app.window.favourites.shownCards[0], "Unpin")
    app.until(lambda: pinned(app) == ("Gain", "TriggerMode", "AcquisitionFrameRate"))
    choose_from_menu(app, app.window.favourites.shownCards[0], "Pin the usual controls")
    app.until(lambda: pinned(app) == USUAL)


def test_many_favourites_take_several_lines_and_too_many_are_refused(app):
    source = app.program.open_sources.current
    names = [d.name for d in source.features.root.descriptions() if d.name not in USUAL]
    for name in names[: MOST_PINNED - 3]:
        app.program.feature_controls.favourites.add(name)
    app.until(lambda: len(pinned(app)) == MOST_PINNED)
    strip = app.window.favourites
    app.wait_for_cards(MOST_PINNED)
    app.until(lambda: len({card.y() for card in strip.shownCards}) > 1)
    app.until(lambda: all(card.geometry().right() <= strip.width() for card in strip.shownCards))
    app.settled(lambda: [card.geometry() for card in strip.shownCards])
    assert strip.place_at(strip.shownCards[3].geometry().center() + QPoint(-60, 0)) == 3
    app.program.feature_controls.favourites.add(names[MOST_PINNED])
    assert "no more than 12" in app.errors[0]


def test_low_cards_in_one_line_need_no_scroll_bar(qtbot):
    """Their height is that of a font, a language, or a camera that is only read."""
    strip = FavouritesStrip()
    qtbot.addWidget(strip)
    font = strip.font()
    font.setPixelSize(9)  # whatever fonts are installed
    strip.setFont(font)
    strip.setFavourites([FeatureDescription(name="Gain", kind=FeatureKind.FLOAT)])
    (line,) = strip.heightsOfLines(CARD_WIDTH)
    assert strip.minimumSizeHint().height() <= line < LINE_HEIGHT, "the area is as high as the line"


def test_without_controls_the_hint_is_seen_and_nothing_scrolls(app):
    area, strip = app.window.favouritesArea, app.window.favourites
    strip.setFavourites([])
    app.until(lambda: area.height() == strip.sizeHint().height())
    app.until(lambda: strip.height() <= area.viewport().height())
    assert strip.hintLabel.visibleRegion().boundingRect() == strip.hintLabel.rect()
    assert not area.verticalScrollBar().isVisible()


def test_a_model_of_camera_gets_its_favourites_and_its_layout_back(app):
    app.program.feature_controls.favourites.add("TriggerMode")
    app.program.feature_controls.favourites.remove("Gain")
    chosen = ("ExposureTime", "AcquisitionFrameRate", "TriggerMode")
    app.window.histogramDock.show()
    app.program.open_sources.close_current()
    app.until(lambda: pinned(app) == ())
    app.window.histogramDock.hide()
    app.connect("sim:?width=64&height=64")
    app.until(lambda: pinned(app) == chosen)
    assert app.window.histogramDock.isVisible()


def test_another_model_keeps_its_own(tmp_path):
    store = Preferences(QSettings(str(tmp_path / "settings.ini"), QSettings.IniFormat))
    one = camera_model(DeviceInfo("gige:1", vendor="Acme/Co", model="One & only"))
    two = camera_model(DeviceInfo("gige:2", vendor="Acme/Co", model="Two"))
    store.keep_favourites(one, ["Gain", "Gamma"])
    store.keep_favourites(two, [])
    store._store.sync()
    again = Preferences(QSettings(str(tmp_path / "settings.ini"), QSettings.IniFormat))
    assert again.favourites_of(one) == ["Gain", "Gamma"]
    assert again.favourites_of(two) == []
    assert again.favourites_of("Other") is None
    again.keep_favourites(one, None)
    assert again.favourites_of(one) is None
    assert camera_model(DeviceInfo("ros2:/camera")) == "ros2:/camera"


def test_what_this_camera_does_not_have_is_left_out(make_app):
    app = make_app()
    app.preferences.keep_favourites("grabbergui Simulated camera", ["Nothing", "Gain"])
    app.connect("sim:?width=64&height=64")
    app.until(lambda: pinned(app) == ("Gain",))

"""The list of sources: what is in view, also while a search changes it."""

import pytest
from PyQt5.QtGui import QRegion
from PyQt5.QtWidgets import QAbstractScrollArea, QApplication

from grabbergui.core.identity import DeviceInfo
from grabbergui.models.sources import ListedSource
from grabbergui.ui.views.source_list import SourceListView


@pytest.fixture
def view(qtbot):
    made = SourceListView()
    qtbot.addWidget(made)
    made.resize(250, 300)
    made.show()
    return made


def sources(count: int) -> list[ListedSource]:
    infos = [DeviceInfo(f"gige:127.0.0.{number}", f"camera {number}", "", "") for number in range(count)]
    return [ListedSource(info) for info in infos]


def is_in_view(view, row):
    """Whether all of a card is seen."""
    card = view.sourceList.visualItemRect(view.sourceList.item(row))
    seen = view.sourceList.viewport().visibleRegion().intersected(QRegion(card))
    return seen.boundingRect() == card


def test_what_is_in_view_stays_there_when_a_search_finds_another(view, qtbot):
    view.setSources(sources(20))
    view.sourceList.setCurrentRow(12)
    qtbot.waitUntil(lambda: is_in_view(view, 12))
    bar = view.scrollArea.verticalScrollBar()
    bar.setValue(bar.value() - 20)
    before = bar.value()

    view.setSources(sources(21))
    QApplication.processEvents()

    assert bar.value() == before
    assert view.sourceList.currentRow() == 12


def test_the_source_that_is_opened_comes_into_view_also_in_a_lower_panel(view, qtbot):
    view.setCurrent("gige:127.0.0.15", True)
    view.setSources(sources(20))
    qtbot.waitUntil(lambda: is_in_view(view, 15))
    view.resize(250, 200)
    qtbot.waitUntil(lambda: is_in_view(view, 15))


def test_no_tile_is_cut_for_nothing_above_the_one_that_comes_into_view(view, qtbot):
    """The first tile was half out of view, though both had room: the list scrolled before it was laid out."""
    listed = [ListedSource(source.info, connected=row < 2) for row, source in enumerate(sources(6))]
    tiles = [view.gallery.addTile() for _ in range(2)]
    view.setSources(listed)
    qtbot.waitUntil(lambda: view.scrollArea.verticalScrollBar().maximum() > 30)
    view.scrollArea.verticalScrollBar().setValue(30)
    tiles[1].setCurrent(True)
    view.setCurrent(listed[1].info.uri, True)
    qtbot.waitUntil(lambda: tiles[0].visibleRegion().boundingRect() == tiles[0].rect())
    assert tiles[1].visibleRegion().boundingRect() == tiles[1].rect()


def test_no_card_is_cut_for_nothing_above_the_one_that_comes_into_view(view, qtbot):
    view.setCurrent("gige:127.0.0.1", True)
    view.setSources(sources(12))
    qtbot.waitUntil(lambda: view.scrollArea.verticalScrollBar().maximum() > 30)
    view.scrollArea.verticalScrollBar().setValue(30)
    view.resize(250, 260)
    qtbot.waitUntil(lambda: is_in_view(view, 0) and is_in_view(view, 1))


def test_tiles_and_sources_scroll_together(view, qtbot):
    """Tiles and list had a scroll bar each, and little room."""
    view.setSources(sources(20))
    for _ in range(4):
        view.gallery.addTile()
    heights = [view.sourceList.sizeHintForRow(row) for row in range(20)]
    qtbot.waitUntil(lambda: view.sourceList.height() == sum(heights))
    bars = [area.verticalScrollBar() for area in view.findChildren(QAbstractScrollArea)]
    assert [bar for bar in bars if bar.isVisible()] == [view.scrollArea.verticalScrollBar()]
    assert view.gallery.y() < view.sourceList.y()


def test_where_not_all_sources_have_room_whole_cards_are_cut(view):
    """Beside the features, one and a half tiles and half a card were seen."""
    view.setSources(sources(10))
    card, whole = view.sourceList.sizeHintForRow(0), view.scrollArea.widget().sizeHint().height()
    below = whole - 10 * card
    assert below >= 0 and view.cardsCut(0) == view.cardsCut(-50) == 0
    for pixels, cards in ((1, 1), (card, 1), (card + 1, 2), (3 * card, 3)):
        assert view.cardsCut(below + pixels) == below + cards * card

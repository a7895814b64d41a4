"""The list of sources, while a search changes it."""

from grabbergui.core.identity import DeviceInfo
from grabbergui.models.sources import ListedSource
from grabbergui.ui.views.source_list import SourceListView


def sources(count: int) -> list[ListedSource]:
    infos = [DeviceInfo(f"gige:127.0.0.{number}", f"camera {number}", "", "") for number in range(count)]
    return [ListedSource(info) for info in infos]


def test_what_is_in_view_stays_there_when_a_search_finds_another(qtbot):
    view = SourceListView()
    qtbot.addWidget(view)
    view.resize(250, 300)
    view.show()
    view.setSources(sources(20))
    view.sourceList.setCurrentRow(12)
    view.sourceList.verticalScrollBar().setValue(500)

    view.setSources(sources(21))

    assert view.sourceList.verticalScrollBar().value() == 500
    assert view.sourceList.currentRow() == 12


def test_the_source_that_is_opened_comes_into_view(qtbot):
    view = SourceListView()
    qtbot.addWidget(view)
    view.resize(250, 300)
    view.show()

    view.setCurrent("gige:127.0.0.15", True)
    view.setSources(sources(20))

    item = view.sourceList.selectedItems()[0]
    assert view.sourceList.viewport().rect().intersects(view.sourceList.visualItemRect(item))

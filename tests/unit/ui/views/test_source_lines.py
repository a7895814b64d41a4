"""Lines of the source list: no two cameras look alike."""

import pytest
from PyQt5.QtCore import Qt
from PyQt5.QtGui import QFontMetrics
from PyQt5.QtWidgets import QMenu

from grabbergui.core.identity import DeviceInfo
from grabbergui.models.sources import ListedSource
from grabbergui.models.unavailable import Unavailable
from grabbergui.ui.interface_language import speak
from grabbergui.ui.views.source_list import SourceListView
from grabbergui.ui.widgets.labels import MOST_LINES, name_lines

ALIKE = (
    "Front camera of the packing line in hall A, left side",
    "Front camera of the packing line in hall B, left side",
)


@pytest.fixture
def view(qtbot):
    made = SourceListView()
    qtbot.addWidget(made)
    made.resize(180, 500)
    made.show()
    return made


def test_names_that_differ_in_the_middle_are_whole(view):
    for name in ALIKE:
        lines = name_lines(name, view.font(), 160)
        assert " ".join(lines) == name and 1 < len(lines) <= MOST_LINES
        assert all(QFontMetrics(view.font()).horizontalAdvance(line) <= 160 for line in lines)


def test_a_card_is_as_high_as_its_name_needs_and_the_images_of_two_differ(view, qtbot):
    infos = [DeviceInfo(f"gige:{n}", user_name=name) for n, name in enumerate((*ALIKE, "short"))]
    view.setSources([ListedSource(info) for info in infos])
    items = [view.sourceList.item(row) for row in range(3)]
    rects = [view.sourceList.visualItemRect(item) for item in items]
    assert rects[0].height() > rects[2].height()
    qtbot.waitUntil(lambda: view.sourceList.height() > rects[2].bottom())
    images = [view.sourceList.grab(rect).toImage() for rect in rects[:2]]
    assert images[0] != images[1]
    view.resize(600, 500)
    qtbot.waitUntil(
        lambda: (
            view.sourceList.visualItemRect(items[0]).height()
            == view.sourceList.visualItemRect(items[2]).height()
        )
    )


def test_cards_become_lower_where_the_list_alone_becomes_wider(view, qtbot):
    view.setSources([ListedSource(DeviceInfo("gige:1", user_name=ALIKE[0]))])
    item = view.sourceList.item(0)
    view.sourceList.setFixedSize(160, 300)
    qtbot.waitUntil(lambda: view.sourceList.visualItemRect(item).width() < 200)
    high = view.sourceList.visualItemRect(item).height()
    view.sourceList.setFixedSize(500, 300)
    qtbot.waitUntil(lambda: view.sourceList.visualItemRect(item).height() < high)


def test_a_name_without_end_is_shortened_in_its_middle(view):
    lines = name_lines("file:/home/somebody/" + "recordings/" * 40 + "last.mcap", view.font(), 160)
    assert len(lines) <= MOST_LINES
    assert "".join(lines).startswith("file:/home") and "".join(lines).endswith("last.mcap")
    assert "…" in "".join(lines)


def test_the_button_connects_to_a_typed_address_and_shows_an_open_source_that_is_selected(view):
    view.setSources([ListedSource(DeviceInfo(f"sim:{name}"), connected=True) for name in "ab"])
    view.setCurrent("sim:a", connected=True)
    view.sourceList.setCurrentRow(1)
    assert view.connectButton.text() == "Show"
    view.addressEdit.setText("sim:colour")
    assert view.connectButton.text() == "Connect"
    assert view.besideButton.isEnabled()


def test_a_screen_reader_says_the_state_of_a_source_in_the_windows_language(view, qapp, request):
    speak(qapp, "es")
    request.addfinalizer(lambda: speak(qapp, "en"))
    view.setSources([ListedSource(DeviceInfo("sim:"), connected=True)])
    assert "conectada" in view.sourceList.item(0).data(Qt.AccessibleTextRole)


def test_the_known_addresses_are_hidden_once_an_address_is_used(view, qtbot):
    """Ctrl+B left them open over the list, where they took the next keys."""
    view.setRecent(["gige:127.0.0.1"])
    view.activateWindow()
    view.focusAddress()
    qtbot.keyClicks(view.addressEdit, "gige:127")
    qtbot.waitUntil(view.addressEdit.completer().popup().isVisible)
    view.requestBeside()
    assert not view.addressEdit.completer().popup().isVisible()


def menu(view, row):
    """The entries of a line's menu."""
    place = view.sourceList.visualItemRect(view.sourceList.item(row)).center()
    view.sourceList.customContextMenuRequested.emit(place)
    opened = view.findChildren(QMenu)[-1]
    texts = [action.text() for action in opened.actions()]
    opened.close()
    return texts


def test_the_menu_of_a_line_offers_what_applies(view):
    """It offered *Connect* on a camera that was connected."""
    infos = [DeviceInfo(f"gige:{name}", user_name=name) for name in ("current", "other", "closed")]
    view.setSources([ListedSource(info, connected=info.user_name != "closed") for info in infos])
    view.setCurrent("gige:current", True)
    assert menu(view, 0) == ["Disconnect"]
    assert menu(view, 1) == ["Show"]
    assert menu(view, 2)[:3] == ["Connect", "Connect without starting", "Open beside"]


def test_delete_forgets_a_line_that_was_added_by_hand(view, qtbot):
    infos = [DeviceInfo("gige:found"), DeviceInfo("gige:typed")]
    view.setSources([ListedSource(infos[0]), ListedSource(infos[1], manual=True, problem="not found")])
    forgotten = []
    view.forgetRequested.connect(forgotten.append)
    for row in range(2):
        view.sourceList.setCurrentRow(row)
        view.sourceList.setFocus()
        qtbot.keyClick(view.sourceList, Qt.Key_Delete)
    assert forgotten == ["gige:typed"]


def test_connect_is_offered_for_the_selected_source(view):
    """With another source selected, *Connect* was grey: it looked at the current one only."""
    infos = [DeviceInfo("gige:current"), DeviceInfo("gige:closed")]
    view.setSources([ListedSource(infos[0], connected=True), ListedSource(infos[1])])
    reasons = []
    view.connectableChanged.connect(reasons.append)
    view.setCurrent("gige:current", True)
    assert reasons[-1] is Unavailable.PRESENT
    view.sourceList.setCurrentRow(1)
    assert reasons[-1] is None and view.unavailable is None
    view.sourceList.setCurrentRow(0)
    assert reasons[-1] is Unavailable.PRESENT
    view.addressEdit.setText("sim:")
    assert reasons[-1] is None

"""The list of changes: it follows what is new, and shows whose changes are wanted."""

from dataclasses import replace

import pytest

from grabbergui.core.settings import SettingKey
from grabbergui.models.change import Change, Origin
from grabbergui.ui.views.changes_panel import ChangesPanel, ChangeTable


@pytest.fixture
def panel(qtbot):
    made = ChangesPanel()
    qtbot.addWidget(made)
    made.resize(500, 180)
    made.show()
    return made


def change(number, origin=Origin.OPERATOR):
    return Change(number, float(number), SettingKey("Gain"), number - 1, number, origin)


def note(panel, first, last):
    for number in range(first, last):
        panel.noteChange(change(number))


def last_row_is_whole(panel):
    table = panel.table
    bottom = table.visualRect(table.model().index(table.model().rowCount() - 1, 0)).bottom()
    return 0 < bottom <= table.viewport().height()


def test_new_rows_are_followed_also_those_that_came_while_the_panel_was_hidden(panel, qtbot):
    panel.hide()
    note(panel, 1, 60)
    panel.show()
    qtbot.waitUntil(lambda: last_row_is_whole(panel))
    note(panel, 60, 80)
    qtbot.waitUntil(lambda: last_row_is_whole(panel))
    panel.resize(500, 130)
    qtbot.waitUntil(lambda: last_row_is_whole(panel))


def test_a_narrow_panel_shows_what_changed_to_which_value(panel):
    """On a laptop the new values were behind a scroll bar, and the panel took width from the image."""
    note(panel, 1, 3)
    assert not panel.table.isColumnHidden(ChangeTable.BEFORE)
    wide = panel.layout().minimumSize().width()
    panel.resize(300, 200)
    shown = [column for column in range(6) if not panel.table.isColumnHidden(column)]
    assert shown == [ChangeTable.TIME, ChangeTable.FEATURE, ChangeTable.AFTER]
    assert panel.layout().minimumSize().width() < wide
    panel.resize(500, 180)
    assert not panel.table.isColumnHidden(ChangeTable.BEFORE)


def test_who_scrolled_up_stays_there_until_the_end_is_reached_again(panel, qtbot):
    note(panel, 1, 60)
    bar = panel.table.verticalScrollBar()
    bar.setValue(5)
    note(panel, 60, 70)
    qtbot.wait(20)
    assert bar.value() == 5
    bar.setValue(bar.maximum())
    note(panel, 70, 80)
    qtbot.waitUntil(lambda: last_row_is_whole(panel))


def test_the_cameras_own_changes_can_be_hidden(panel):
    changes = [change(1), change(2, Origin.CAMERA), change(3, Origin.NETWORK)]
    panel.whoseChanged.connect(lambda: panel.setChanges(changes))
    for index, numbers in ((1, [1, 3]), (2, [1]), (0, [1, 2, 3])):
        panel.whoseBox.setCurrentIndex(index)
        assert [shown.number for shown in panel.chosen] == numbers


def cells(panel, row):
    table = panel.table.model()
    return [table.index(row, column).data() for column in (1, 2, 3)]


def test_a_change_that_is_back_at_its_first_value_leaves_the_list(panel):
    note(panel, 1, 4)
    panel.noteChange(replace(change(2), after=1))
    panel.noteChange(replace(change(3), after=7))
    panel.noteChange(replace(change(9), after=8))
    assert [cells(panel, row) for row in range(2)] == [["Gain", "0", "1"], ["Gain", "2", "7"]]
    assert panel.table.model().rowCount() == 2


def test_values_that_differ_in_late_digits_are_shown_with_all_of_them(panel):
    panel.noteChange(replace(change(1), before=16666.6666, after=16666.6667))
    assert cells(panel, 0) == ["Gain", "16666.6666", "16666.6667"]

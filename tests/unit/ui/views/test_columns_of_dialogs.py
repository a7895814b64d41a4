"""Fields and buttons of dialogs, seen whole and in line."""

import logging

import pytest
from PyQt5.QtWidgets import QAbstractButton

from grabbergui.models.log_book import LogLine
from grabbergui.ui.theme import Theme, dress
from grabbergui.ui.views.help_views import LogPanel
from grabbergui.ui.views.report_dialog import ReportDialog
from grabbergui.ui.views.share_dialog import ShareDialog


@pytest.fixture
def shown(qapp, qtbot, request):
    request.addfinalizer(lambda: qapp.setStyleSheet(""))
    dress(qapp, Theme.DARK)

    def show(widget):
        qtbot.addWidget(widget)
        widget.show()
        return widget

    return show


def test_the_fields_of_both_networks_stand_in_the_same_columns(shown):
    """*Name* of ROS 2 began left of that of YARP, and its button was narrower."""
    dialog = shown(ShareDialog())
    dialog.layout().activate()
    for name in ("nameEdit", "shareButton"):
        yarp, ros2 = (getattr(box, name).geometry() for box in (dialog.yarpBox, dialog.ros2Box))
        assert (yarp.x(), yarp.width()) == (ros2.x(), ros2.width()), name


def test_standard_buttons_have_no_icons(shown):
    """*Close* had a black cross, also on a dark ground; other dialogs have none."""
    buttons = shown(ReportDialog()).buttons.findChildren(QAbstractButton)
    assert len(buttons) == 2 and all(button.icon().isNull() for button in buttons)


def test_the_log_shows_where_its_lines_begin(shown):
    panel = LogPanel()
    panel.resize(280, 160)
    shown(panel)
    for number in range(20):
        panel.addLine(LogLine(1e9, logging.INFO, "grabbergui.settings", f"{number}: {'long ' * 40}"))
    sideways, down = panel.text.horizontalScrollBar(), panel.text.verticalScrollBar()
    assert sideways.maximum() > 0 and sideways.value() == 0
    assert down.value() == down.maximum() > 0

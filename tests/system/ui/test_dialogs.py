"""Every dialog fits a screen of 800 × 600 pixels, whatever cameras, sets and files are called."""

import importlib
import pkgutil

import pytest
from PyQt5.QtCore import QPoint
from PyQt5.QtWidgets import QDialog, QPushButton

import grabbergui.rig.ui
import grabbergui.ui.views
from every_case import every_case
from grabbergui.core.settings import SettingKey
from grabbergui.models.settings.feature_set import FeatureSet
from grabbergui.models.settings.loading import LoadReport, SettingOutcome, SettingReport
from grabbergui.ui.dialog_style import MARGIN, SPACING
from grabbergui.ui.theme import Theme, dress
from grabbergui.ui.views.main_window import MainWindow
from grabbergui.ui.views.settings_dialogs import SettingsReport
from made_dialogs import MADE
from small_screen import check_fits


@pytest.fixture
def window(qtbot, qapp):
    dress(qapp, Theme.LIGHT)
    made = MainWindow()
    qtbot.addWidget(made)
    return made


def test_no_dialog_is_missing_here():
    modules = [
        importlib.import_module(f"{package.__name__}.{module.name}")
        for package in (grabbergui.ui.views, grabbergui.rig.ui)
        for module in pkgutil.iter_modules(package.__path__)
    ]
    found = {
        each
        for module in modules
        for each in vars(module).values()
        if isinstance(each, type) and issubclass(each, QDialog) and each.__module__ == module.__name__
        if not each.__subclasses__()  # a base of dialogs is none itself
    }
    assert found == set(MADE)


@every_case("kind", MADE, ids=lambda kind: kind.__name__)
def test_a_dialog_fits_800_by_600_and_its_buttons_are_whole(window, monkeypatch, kind):
    check_fits(kind, lambda: MADE[kind](window), monkeypatch)


@every_case("kind", MADE, ids=lambda kind: kind.__name__)
def test_all_dialogs_have_one_style(window, kind):
    """The same margins; at most one button that acts; *Close*, or a wizard's *Next*, is the last one."""
    dialog = MADE[kind](window)
    layout = dialog.layout()
    margins = layout.contentsMargins()
    edges = {margins.left(), margins.top(), margins.right(), margins.bottom()}
    assert edges in ({MARGIN}, {0}) and layout.spacing() == SPACING
    dialog.show()
    dialog.layout().activate()
    buttons = [each for each in dialog.findChildren(QPushButton) if each.isVisible()]
    assert sum(each.property("primary") is True for each in buttons) <= 1
    if not buttons:
        dialog.close()
        return  # the point cloud's window, which has nothing but the cloud
    lowest = max(each.mapTo(dialog, QPoint(0, 0)).y() for each in buttons)
    row = [each for each in buttons if each.mapTo(dialog, QPoint(0, 0)).y() >= lowest - 4]
    last = max(row, key=lambda each: each.mapTo(dialog, QPoint(0, 0)).x())
    assert last.text().replace("&", "") in ("Close", "Cancel", "Take views")
    dialog.close()


def test_a_report_counts_invalid_lines(qtbot):
    dialog = SettingsReport()
    qtbot.addWidget(dialog)
    setting = SettingReport(SettingKey("Gain"), 1.0, SettingOutcome.EQUAL)
    dialog.setReport("Loaded", LoadReport((setting,), FeatureSet({}), lost_lines=("a.yaml, line 3: odd",)))
    assert dialog.headline.text() == "Equal: 1, not a setting: 1"

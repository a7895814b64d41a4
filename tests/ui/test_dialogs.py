"""Every dialog fits a screen of 800 × 600 pixels, whatever cameras, sets and files are called."""

import importlib
import pkgutil

import pytest
from PyQt5.QtWidgets import QDialog

import grabbergui.ui.views
from grabbergui.core.environment import MANUAL
from grabbergui.core.settings import SettingKey
from grabbergui.doctor.findings import Finding, Level
from grabbergui.models.settings.feature_set import Difference, FeatureSet
from grabbergui.models.settings.loading import LoadReport, SettingOutcome, SettingReport
from grabbergui.models.settings.user_sets import UserSet
from grabbergui.models.share import Network, ReaderRate, Remedy, ShareOptions, ShareState, ShareStatus
from grabbergui.net.readers import Reader
from grabbergui.ui.theme import Theme, dress
from grabbergui.ui.views.calibration_dialogs import CalibrationChoiceDialog, CalibrationDialog
from grabbergui.ui.views.frame_data_dialog import FrameDataDialog
from grabbergui.ui.views.help_views import DoctorDialog, ManualDialog, ShortcutsDialog
from grabbergui.ui.views.image_view import PointCloudDialog
from grabbergui.ui.views.ip_address_dialog import IpAddressDialog
from grabbergui.ui.views.lut_dialog import LutDialog
from grabbergui.ui.views.main_window import MainWindow
from grabbergui.ui.views.report_dialog import ReportDialog
from grabbergui.ui.views.settings_dialogs import SettingsDifference, SettingsReport
from grabbergui.ui.views.share_dialog import ShareDialog
from grabbergui.ui.views.user_sets_dialog import UserSetsDialog
from small_screen import check_fits

LONG = "/home/somebody/" + "the_camera_on_the_left_of_the_head_" * 6


def doctor(window):
    dialog = DoctorDialog(window)
    dialog.addFinding(Finding(Level.PROBLEM, LONG, LONG))
    return dialog


def report(window):
    dialog = SettingsReport(window)
    setting = SettingReport(SettingKey("DeviceUserID"), LONG, SettingOutcome.WRITTEN, before="", reason=LONG)
    dialog.setReport(LONG, LoadReport((setting,), FeatureSet({}), f"{LONG} ended"))
    return dialog


def camera_report(window):
    dialog = ReportDialog(window)
    dialog.setContents([LONG] * 40)
    return dialog


def difference(window):
    dialog = SettingsDifference(window)
    names = (f"{LONG}1.yaml", f"{LONG}2.yaml")
    dialog.setDifferences(names, [Difference(SettingKey("DeviceUserID"), LONG, "")], True)
    return dialog


def share(window):
    dialog = ShareDialog(window)
    dialog.setCamera(LONG)
    options, reader = ShareOptions(LONG, LONG), ReaderRate(Reader(LONG, LONG, LONG, 1, 1))
    broken = ShareStatus(Network.YARP, options, ShareState.FAILED, (), (), LONG, Remedy.NAME_SERVER)
    running = ShareStatus(Network.ROS2, options, ShareState.ON, (LONG,), (reader,))
    dialog.setStatuses([broken, running])
    return dialog


def ip_address(window):
    dialog = IpAddressDialog(window)
    dialog.setCamera(LONG, "00:30:53:0a:0b:0c", LONG)
    dialog.setOutcome(LONG, good=False)
    return dialog


def frame_data(window):
    dialog = FrameDataDialog(window)
    dialog.setRows([(LONG, LONG)] * 40, chunks=False)
    return dialog


def user_sets(window):
    dialog = UserSetsDialog(window)
    dialog.setSets([UserSet("UserSet1", LONG, savable=True, startable=True, starts=True)])
    return dialog


MADE = {
    CalibrationChoiceDialog: lambda window: CalibrationChoiceDialog(LONG, window),
    CalibrationDialog: CalibrationDialog,
    DoctorDialog: doctor,
    FrameDataDialog: frame_data,
    IpAddressDialog: ip_address,
    LutDialog: LutDialog,
    ManualDialog: lambda window: ManualDialog(MANUAL, window),
    PointCloudDialog: PointCloudDialog,
    ReportDialog: camera_report,
    SettingsDifference: difference,
    SettingsReport: report,
    ShareDialog: share,
    ShortcutsDialog: lambda window: ShortcutsDialog(window.menuBar(), window),
    UserSetsDialog: user_sets,
}


@pytest.fixture
def window(qtbot, qapp):
    dress(qapp, Theme.LIGHT)
    made = MainWindow()
    qtbot.addWidget(made)
    return made


def test_no_dialog_is_missing_here():
    views = grabbergui.ui.views
    names = [module.name for module in pkgutil.iter_modules(views.__path__)]
    modules = [importlib.import_module(f"{views.__name__}.{name}") for name in names]
    found = {
        each
        for module in modules
        for each in vars(module).values()
        if isinstance(each, type) and issubclass(each, QDialog) and each.__module__ == module.__name__
        if not each.__subclasses__()  # a base of dialogs is none itself
    }
    assert found == set(MADE)


@pytest.mark.parametrize("kind", MADE, ids=lambda kind: kind.__name__)
def test_a_dialog_fits_800_by_600_and_its_buttons_are_whole(window, monkeypatch, kind):
    check_fits(kind, lambda: MADE[kind](window), monkeypatch)


def test_a_report_counts_invalid_lines(qtbot):
    dialog = SettingsReport()
    qtbot.addWidget(dialog)
    setting = SettingReport(SettingKey("Gain"), 1.0, SettingOutcome.EQUAL)
    dialog.setReport("Loaded", LoadReport((setting,), FeatureSet({}), lost_lines=("a.yaml, line 3: odd",)))
    assert dialog.headline.text() == "1 equal, 1 not a setting"

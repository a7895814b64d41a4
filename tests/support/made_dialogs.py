"""Every dialog of the window, filled with long texts."""

from grabbergui.core.environment import MANUAL
from grabbergui.core.file_access import CameraFile
from grabbergui.core.settings import SettingKey
from grabbergui.doctor.findings import Finding, Level
from grabbergui.models.settings.feature_set import Difference, FeatureSet
from grabbergui.models.settings.loading import LoadReport, SettingOutcome, SettingReport
from grabbergui.models.settings.user_sets import UserSet
from grabbergui.models.share import Network, ReaderRate, Remedy, ShareOptions, ShareState, ShareStatus
from grabbergui.net.readers import Reader
from grabbergui.rig.camera_clock import ClockState
from grabbergui.rig.overview import BudgetOverview, CameraLine, RigOverview
from grabbergui.rig.set_statistics import SetCounts
from grabbergui.rig.ui.new_rig_dialog import NewRigDialog
from grabbergui.rig.ui.rig_dialog import RigDialog
from grabbergui.ui.views.calibration_dialogs import CalibrationChoiceDialog, CalibrationDialog
from grabbergui.ui.views.camera_events_dialog import CameraEventsDialog
from grabbergui.ui.views.camera_files_dialog import CameraFilesDialog
from grabbergui.ui.views.doctor_dialog import DoctorDialog
from grabbergui.ui.views.frame_data_dialog import FrameDataDialog
from grabbergui.ui.views.help_views import ManualDialog, ShortcutsDialog
from grabbergui.ui.views.image_view import PointCloudDialog
from grabbergui.ui.views.ip_address_dialog import IpAddressDialog
from grabbergui.ui.views.lut_dialog import LutDialog
from grabbergui.ui.views.report_dialog import ReportDialog
from grabbergui.ui.views.settings_dialogs import SettingsDifference, SettingsReport
from grabbergui.ui.views.share_dialog import ShareDialog
from grabbergui.ui.views.user_sets_dialog import UserSetsDialog

LONG = "/home/somebody/" + "the_camera_on_the_left_of_the_head_" * 6


def doctor(window):
    dialog = DoctorDialog(window)
    dialog.addFinding(Finding(Level.PROBLEM, LONG, LONG, lambda: None))
    return dialog


def events(window):
    dialog = CameraEventsDialog(window)
    dialog.setSwitches({LONG: True})
    dialog.setRows([(LONG, LONG, LONG)])
    return dialog


def camera_files(window):
    dialog = CameraFilesDialog(window)
    dialog.setFiles([CameraFile(LONG, 5, ("Read",), {LONG: LONG})], reachable=True)
    dialog.setOutcome(LONG, good=False)
    dialog.setBusy(True)
    return dialog


def new_rig(window):
    dialog = NewRigDialog(window)
    dialog.setSources([(LONG, LONG, True)])
    dialog.setProblem(LONG)
    dialog.triggerBox.setCurrentIndex(3)
    return dialog


def rig(window):
    dialog = RigDialog(window)
    dialog.setOverview(
        RigOverview(SetCounts(), (1.0, 2.0), (CameraLine(LONG, 1, 1, ClockState("host", problem=LONG)),))
    )
    dialog.setBudget(BudgetOverview((("camera", "set"), (LONG, LONG)), (LONG,), {}))
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
    CameraEventsDialog: events,
    CameraFilesDialog: camera_files,
    NewRigDialog: new_rig,
    RigDialog: rig,
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

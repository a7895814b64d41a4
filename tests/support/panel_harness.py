"""The feature panel, the strip of favourites and their controller on a grabber, without the window."""

from grabbergui.core.features import AccessMode, EnumEntry, Feature, FeatureKind, Visibility
from grabbergui.models.features.tree import FeatureTreeModel
from grabbergui.models.features.worker import FeatureWorker
from grabbergui.ui.controllers.features import FeatureController
from grabbergui.ui.editors.feature_row import FeatureRow
from grabbergui.ui.views.favourites import FavouritesStrip
from grabbergui.ui.views.feature_panel import FeaturePanel, Section

K, A = FeatureKind, AccessMode
MODES = tuple(EnumEntry(name) for name in ("Off", "Once", "Continuous"))


def feature(name, kind, value=None, category="AcquisitionControl", access=A.READ_WRITE, **more):
    return Feature(name=name, kind=kind, value=value, category=category, access=access, **more)


def camera_features():
    return [
        feature("DeviceUserID", K.STRING, "cam", "DeviceControl"),
        feature("Width", K.INTEGER, 640, "ImageFormatControl", minimum=16, maximum=2448, increment=16),
        feature("TriggerSelector", K.ENUMERATION, "FrameStart", entries=(EnumEntry("FrameStart"),)),
        feature("TriggerMode", K.ENUMERATION, "Off", entries=MODES[:1], selectors=("TriggerSelector",)),
        feature("TriggerSoftware", K.COMMAND, access=A.WRITE_ONLY),
        feature(
            "ExposureTime", K.FLOAT, 1e4, minimum=10.0, maximum=1e6, unit="us", auto="ExposureAuto",
            tooltip="How long the shutter is open.",
        ),
        feature("ExposureAuto", K.ENUMERATION, "Off", entries=MODES),
        feature("AcquisitionFrameRateAbs", K.FLOAT, 25.0, minimum=1.0, maximum=100.0),
        feature("Gain", K.FLOAT, 6.0, "AnalogControl", minimum=0.0, maximum=48.0),
        feature("BlackLevel", K.FLOAT, 1.0, "AnalogControl", visibility=Visibility.EXPERT),
        feature("Fuse", K.INTEGER, 1, "AnalogControl", visibility=Visibility.GURU),
    ]  # fmt: skip


class PanelHarness:
    """Panel, strip and controller on a grabber."""

    def __init__(self, qtbot, grabber):
        self.qtbot = qtbot
        self.grabber = grabber
        self.panel, self.strip = FeaturePanel(), FavouritesStrip()
        for view in (self.panel, self.strip):
            qtbot.addWidget(view)
        self.panel.levelBox.setCurrentText("Expert")  # beginners see what is pinned above the image only
        self.panel.resize(340, 700)
        self.strip.resize(900, 80)
        self.controller = FeatureController(self.panel, self.strip)
        self.errors = []
        self.worker = FeatureWorker()
        self.model = FeatureTreeModel(grabber, self.worker)
        self.model.failed.connect(lambda error: self.errors.append(str(error)))
        self.panel.show()
        self.strip.show()
        self.controller.set_model(self.model)

    def close(self):
        self.controller.set_model(None)
        self.model.close()
        self.worker.submit(self.grabber.close)
        assert self.worker.close()

    def row(self, name, view=None):
        """The row of a feature with its editor, waited for."""
        rows = (view or self.panel).rows

        def built():
            return bool(rows.rows(name)) and rows.rows(name)[0].editor is not None

        self.qtbot.waitUntil(built)
        return rows.rows(name)[0]

    def filled(self):
        """Wait until every row on show has its editor."""

        def full():
            rows = self.panel.rows
            return all(
                rows.rows(name) and all(row.editor is not None for row in rows.rows(name))
                for name in self.panel.watched
            )

        self.qtbot.waitUntil(full)

    def shown(self):
        self.filled()
        return [row.name for row in self.panel.findChildren(FeatureRow) if row.isVisible()]

    def open_everything(self):
        """Open each section, for gurus."""
        self.panel.levelBox.setCurrentText("Guru")
        while closed := [s for s in self.panel.findChildren(Section) if not (s.open or s.isHidden())]:
            for section in closed:
                section.header.click()
        self.filled()

    def written(self, name):
        return [value for written, value, _ in self.grabber.writes if written == name]

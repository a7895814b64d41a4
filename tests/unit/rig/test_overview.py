"""A rig's state as rows, and the budget of its link in its file."""

import pytest

from fakes import ScriptedGrabber
from grabbergui.core.features import AccessMode, Feature, FeatureKind
from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.settings import SettingKey
from grabbergui.rig import rig_file, source
from grabbergui.rig.grabber import RigGrabber
from grabbergui.rig.overview import budget, overview, remove_budget, write_budget
from grabbergui.rig.rig_file import CameraEntry, LinkEntry, RigEntry

SMALL = "sim:?width=64&height=48&fps=20"
NAMES = ("left", "right")


@pytest.fixture
def entry():
    cameras = {name: CameraEntry(f"{SMALL}&serial={name}", {"ExposureTime": 2000}) for name in NAMES}
    return RigEntry(cameras, link=LinkEntry(rate=1e6))


@pytest.fixture
def rig(entry):
    made = source.of_entry(entry)
    made.open()
    yield made
    made.close()


def test_every_camera_has_a_line_with_its_clock(rig):
    seen = overview(rig)
    assert [each.name for each in seen.cameras] == list(NAMES)
    assert all(each.frames == each.missing == 0 and each.clock for each in seen.cameras)
    assert seen.skews_us == () and seen.counts.sets == 0
    assert rig.cameras["left"].statistics() == StreamStatistics()


def number(name, value):
    return Feature(name=name, kind=FeatureKind.FLOAT, value=value, access=AccessMode.READ_WRITE)


def test_the_budget_is_a_table_and_goes_into_the_file_and_out_of_it_again(entry, tmp_path):
    features = {
        "PayloadSize": 30_000.0,
        "GevSCPSPacketSize": 1500.0,
        "AcquisitionFrameRate": 10.0,
        "GevSCPD": 0.0,
    }
    cameras = {name: ScriptedGrabber(number(*each) for each in features.items()) for name in NAMES}
    planned = budget(RigGrabber(DeviceInfo("rig:"), entry, cameras))
    header, *lines = planned.rows
    assert header[0] == "camera" and [line[0] for line in lines] == [*NAMES, "all"]
    assert not planned.problems and all("GevSCPD" in each for each in planned.settings.values())
    path = tmp_path / "rig.yaml"
    rig_file.write(path, entry)
    write_budget(path, planned)
    for name in NAMES:
        written = rig_file.read(path).cameras[name].settings
        assert written == {"ExposureTime": 2000, **planned.settings[name]}
    assert planned.keys() == {
        SettingKey(f"{name}.{feature}"): value
        for name in NAMES
        for feature, value in planned.settings[name].items()
    }
    remove_budget(path)
    assert rig_file.read(path) == entry

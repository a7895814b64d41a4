"""A rig of simulated cameras as a source."""

import time

import pytest

from grabbergui import sources
from grabbergui.core.errors import SourceNotFoundError, UsageError
from grabbergui.rig import source
from grabbergui.rig.rig_file import CameraEntry, RigEntry, TriggerEntry
from patience import PATIENCE, until

FAST = "sim:?width=64&height=48&fps=50&exposure=1000"


def entry(*names, settings=None, **more):
    return RigEntry({name: CameraEntry(f"{FAST}&serial={name}", settings or {}) for name in names}, **more)


@pytest.fixture
def opened():
    rigs = []

    def open_rig(content):
        rig = source.of_entry(content)
        rigs.append(rig)
        rig.open()
        return rig

    yield open_rig
    for rig in rigs:
        rig.close()


def test_a_lost_frame_does_not_shift_the_next_sets(opened):
    rig = opened(entry("left", "right", clock="fitted", trigger=TriggerEntry("software")))
    queue = rig.open_queue(32)
    rig.start()
    for number in range(6):
        if number == 2:  # only one of them is triggered
            rig.cameras["left"].execute("TriggerSoftware")
        else:
            rig.send_trigger()
        until(lambda n=number: rig.cameras["left"].statistics().frames > n)
        time.sleep(0.06)
    sets = [queue.get(PATIENCE).images for _ in range(6)]
    assert [each.missing for each in sets] == [("right",) if n == 2 else () for n in range(6)]
    assert [each["left"].frame_id for each in sets] == [1, 2, 3, 4, 5, 6]
    assert [each["right"].frame_id for each in sets if not each.missing] == [1, 2, 3, 4, 5]


def test_what_cannot_be_opened_is_named_and_nothing_stays_open(tmp_path):
    absent = CameraEntry("gige:127.254.1.1")
    rig = source.of_entry(RigEntry({"left": CameraEntry(FAST), "right": absent}))
    with pytest.raises(SourceNotFoundError):
        rig.open()
    rig.close()
    with pytest.raises(UsageError, match="a rig cannot contain a rig"):
        source.of_entry(RigEntry({"left": CameraEntry("rig:other.yaml")}))
    with pytest.raises(UsageError, match="rig: needs the file"):
        sources.create("rig:")

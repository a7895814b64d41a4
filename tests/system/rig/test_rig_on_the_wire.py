"""Rigs of simulated GigE Vision cameras: wired to each other, triggered by actions, with drifting clocks."""

import os

import pytest

from grabbergui.cli import main
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige.faults import GigeFaults
from grabbergui.driver.sim.gige.server import GigeCamera
from grabbergui.rig import source
from grabbergui.rig.rig_file import CameraEntry, RigEntry, TriggerEntry
from grabbergui.rig.trigger_diagnosis import TriggerCause
from patience import PATIENCE, allowance, until

NET = f"127.89.{os.getpid() % 250 + 1}"
"Network of this test run alone: others may run at the same time."
SMALL = {reg.WIDTH: 64, reg.HEIGHT: 48, reg.EXPOSURE_TIME: 3000.0, reg.FRAME_RATE: 20.0}
NAMES = ("left", "right", "top")


@pytest.fixture
def cameras():
    faults = GigeFaults(loss=0.01)
    started = {
        name: GigeCamera(f"{NET}.{number}", power_on=SMALL, drift=drift, faults=faults)
        for number, (name, drift) in enumerate(zip(NAMES, (50e-6, -50e-6, 0.0), strict=True), 1)
    }
    yield started
    for camera in started.values():
        camera.close()


def opened(cameras, **more):
    entry = RigEntry({name: CameraEntry(f"gige:{each.address}") for name, each in cameras.items()}, **more)
    rig = source.of_entry(entry)
    rig.open()
    return rig


def sets_of(rig, count):
    queue = rig.open_queue(32)
    rig.start()
    return [queue.get(PATIENCE).images for _ in range(count)]


def test_one_camera_triggers_the_others_by_its_exposure(cameras):
    for name in ("right", "top"):
        cameras["left"].wire_to(cameras[name])
    trigger = TriggerEntry("line", 20, leader="left")
    rig = opened(cameras, clock="fitted", trigger=trigger)
    try:
        sets = sets_of(rig, 15)
        whole = [each for each in sets if not each.missing]
        assert len(whole) >= 10
        numbers = {each["left"].frame_id - each["right"].frame_id for each in whole}
        # On a busy machine a simulated leader leaves frames out, and a follower misses pulses.
        assert len(numbers) <= 1 + len(sets) - len(whole)
        causes = {each.cause for each in rig.trigger_findings().values()}
        assert causes <= {TriggerCause.NONE, TriggerCause.PULSES_MISSING}
        states = rig.clock_states()
        assert states["left"].drift_ppm < 0 < states["right"].drift_ppm or rig.counts().sets < 60
    finally:
        rig.close()
    left = source.sources.create(f"gige:{cameras['left'].address}")
    left.open()
    assert left.feature("LineSource").value is None  # of Line1, an input
    left.close()


def test_a_cut_wire_is_named(cameras):
    rig = opened(cameras, trigger=TriggerEntry("line", leader="left"))  # nothing is wired
    try:
        queue = rig.open_queue(32)
        rig.start()
        until(lambda: rig.cameras["left"].statistics().frames >= 3)
        findings = rig.trigger_findings()
        assert {each.cause for each in findings.values()} == {TriggerCause.NO_SIGNAL}
        assert "no edge on Line1, it is always low" in findings["top"].sentence
        assert queue.get(PATIENCE).images.missing == ("right", "top")
    finally:
        rig.close()


def test_actions_are_scheduled_by_ptp(cameras):
    rig = opened(cameras, trigger=TriggerEntry("action", 15, ahead=0.1))
    try:
        whole = [each for each in sets_of(rig, 12) if not each.missing]
        assert len(whole) >= 8 and {state.kind for state in rig.clock_states().values()} == {"ptp"}
        stamps = [{frame.timestamp_ns for frame in each.values()} for each in whole]
        spreads = sorted(max(each) - min(each) for each in stamps)
        # The simulated cameras are threads; on a busy machine one of them may begin late.
        assert spreads[len(spreads) // 2] < 1_000_000 * allowance()
    finally:
        rig.close()


def test_actions_make_sets_by_times_of_arrival_too(cameras):
    rig = opened(cameras, clock="host", tolerance=0.0025, trigger=TriggerEntry("action", 10))
    try:
        queue = rig.open_queue(32)
        rig.start()
        until(lambda: not queue.get(PATIENCE).images.missing, "a whole set")
    finally:
        rig.close()


@pytest.mark.parametrize("wire", ["127.0.0.1=127.0.0.2", "127.0.0.1.Line2=x.Line1"])
def test_a_wire_that_is_none_is_refused(wire, capsys):
    assert main(["simulate", "--gige", "--wire", wire]) == 2
    assert "--wire" in capsys.readouterr().err


def test_a_wire_leads_to_a_camera_that_is_simulated(capsys):
    assert main(["simulate", "--gige", f"{NET}.9", "--wire", f"{NET}.9.Line2={NET}.8.Line1"]) == 2
    assert f"there is no camera at {NET}.8" in capsys.readouterr().err


def test_a_camera_that_is_lost_is_not_waited_for_and_comes_back(cameras):
    rig = opened(cameras, clock="fitted", trigger=TriggerEntry("action", 10))
    noticed = []
    rig.noticed.connect(noticed.append)
    try:
        queue = rig.open_queue(256)
        rig.start()
        until(lambda: not queue.get(PATIENCE).images.missing, "a whole set")
        cameras["right"].cut_power()
        until(lambda: queue.get(PATIENCE).images.missing == ("right",), "a set without it")
        until(lambda: noticed, "a notice")
        assert noticed[0].startswith("right") and not rig.lost
        until(lambda: not queue.get(PATIENCE).images.missing, "a whole set again")
    finally:
        rig.close()

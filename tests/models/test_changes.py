"""Changes: noted, undone, made again by a command line and by a program."""

import shlex
import subprocess
import sys
import threading
import time

import pytest

from fakes import ScriptedGrabber
from grabbergui import cli, sources
from grabbergui.core.errors import DeviceLostError, FeatureError
from grabbergui.core.features import AccessMode, Feature, FeatureKind
from grabbergui.core.shared import SharedGrabber
from grabbergui.models.changes import replay
from grabbergui.models.changes.change import Origin
from grabbergui.models.changes.journal import ChangeJournal
from grabbergui.models.changes.noting import CONSEQUENCES, NotingGrabber
from grabbergui.models.changes.reverting import revert
from grabbergui.models.changes.undo_history import MOST_STEPS, PAUSE, Direction, Step
from grabbergui.models.connection import Connection, LinkState
from grabbergui.models.settings.feature_set import FeatureSet, SettingKey, capture, compare
from grabbergui.models.settings.loading import load_onto

UNDO, REDO = Direction.UNDO, Direction.REDO
OPERATOR, CAMERA, NETWORK = Origin.OPERATOR, Origin.CAMERA, Origin.NETWORK


def number(name, value=1.0, **more):
    fields = {"minimum": 0.0, "maximum": 100.0, "access": AccessMode.READ_WRITE, **more}
    return Feature(name=name, kind=FeatureKind.FLOAT, value=value, **fields)


class Bench:
    """A grabber, the operator's hands on it, and a clock."""

    def __init__(self, grabber):
        self.grabber = grabber
        self.now = 100.0
        self.journal = ChangeJournal(clock=lambda: self.now, time_of_day=lambda: 1e9 + self.now)
        self.hands = NotingGrabber(grabber, self.journal, clock=lambda: self.now)
        self.hands.open()  # a camera looks at what moves by itself only while somebody listens

    def value(self, name):
        return self.grabber.feature(name).value

    def write(self, name, value, wait=PAUSE):
        self.hands.write_feature(name, value)
        self.now += wait

    def revert(self, direction, times=1):
        return [problem for _ in range(times) for problem in revert(self.hands, direction)]

    @property
    def log(self):
        return [(str(change), change.origin) for change in self.journal.changes]


@pytest.fixture
def bench():
    return Bench(ScriptedGrabber([number("Gain"), number("Gamma"), number("Exposure", unit="us")]))


@pytest.fixture
def sim():
    camera = sources.create("sim:?width=64&height=64&pixel_format=RGB8")
    camera.open()
    yield Bench(camera)
    camera.close()


# -- the log -----------------------------------------------------------------------------------------
def test_a_write_is_noted_with_its_time_and_both_values(bench):
    noted = []
    bench.journal.noted.connect(noted.append)
    bench.write("Gain", 6.0)
    (change,) = noted
    assert (change.key, change.before, change.after) == (SettingKey("Gain"), 1.0, 6.0)
    assert (change.origin, change.time, change.number) == (OPERATOR, 1e9 + 100, 1)
    assert bench.journal.changes == (change,)


def test_what_the_camera_made_of_a_value_is_noted(bench):
    bench.grabber.on_write = lambda name, value: 5.5
    bench.write("Gain", 6.0)
    assert bench.log == [("Gain 1 → 5.5", OPERATOR)]


def test_a_write_that_changes_nothing_or_is_refused_is_not_noted(bench):
    bench.write("Gain", 1.0)
    with pytest.raises(FeatureError):
        bench.write("Gain", 1000.0)
    assert bench.log == []
    assert bench.journal.next_text(UNDO) == ""


def test_a_drag_is_one_change_and_one_step(bench):
    for value in range(2, 50):
        bench.write("Gain", value, wait=0.05)
    assert bench.log == [("Gain 1 → 49", OPERATOR)]
    assert bench.journal.next_text(UNDO) == "Gain 1 → 49"
    assert bench.revert(UNDO) == []
    assert bench.value("Gain") == 1.0
    assert bench.journal.next_text(UNDO) == ""


def test_a_control_in_hand_is_one_step_however_slow(bench):
    bench.journal.hold("Gain")
    for value in (2, 3, 4):
        bench.write("Gain", value, wait=10 * PAUSE)
    bench.journal.release("Gain")
    bench.write("Gain", 5)
    assert bench.log == [("Gain 1 → 4", OPERATOR), ("Gain 4 → 5", OPERATOR)]
    bench.revert(UNDO, times=2)
    assert bench.value("Gain") == 1.0


def test_what_is_typed_later_is_another_step_though_typing_holds_the_control(bench):
    for value in (2, 3):
        bench.journal.hold("Gain")
        bench.write("Gain", value, wait=0.01)
        bench.journal.release("Gain")
        bench.now += 10 * PAUSE
    assert bench.log == [("Gain 1 → 2", OPERATOR), ("Gain 2 → 3", OPERATOR)]
    bench.revert(UNDO)
    assert bench.value("Gain") == 2


def test_what_comes_between_ends_a_step(bench):
    bench.write("Gain", 2, wait=0.01)
    bench.write("Gamma", 2, wait=0.01)
    bench.write("Gain", 3, wait=0.01)
    assert bench.log == [("Gain 1 → 2", OPERATOR), ("Gamma 1 → 2", OPERATOR), ("Gain 2 → 3", OPERATOR)]
    bench.revert(UNDO)
    assert (bench.value("Gain"), bench.value("Gamma")) == (2, 2)


def test_what_is_dragged_back_leaves_no_step(bench):
    bench.write("Gain", 2, wait=0.01)
    bench.write("Gain", 1, wait=0.01)
    assert bench.journal.next_text(UNDO) == ""


def test_log_and_steps_are_bounded(bench):
    bench.journal._most = 50
    for turn in range(MOST_STEPS + 20):
        bench.write("Gain", 2.0 + turn % 2)
    assert len(bench.journal.changes) == 50
    undone = 0
    while bench.journal.next_text(UNDO):
        bench.revert(UNDO)
        undone += 1
    assert undone == MOST_STEPS


# -- who did it --------------------------------------------------------------------------------------
def test_what_moves_by_itself_was_the_camera(bench):
    bench.hands.watch(bench.grabber.feature("Gain"))
    bench.grabber.set("Gain", 7.0)
    bench.hands.watch(bench.grabber.feature("Gain"))
    assert bench.log == [("Gain 1 → 7", CAMERA)]
    assert bench.journal.next_text(UNDO) == "", "only the operator's own changes are undone"


def test_what_others_change_on_a_shared_camera_was_the_network(bench):
    bench.grabber.shared = True
    bench = Bench(bench.grabber)
    for name in ("Gain", "Gamma"):
        bench.hands.watch(bench.grabber.feature(name))
    bench.grabber.set("Gain", 7.0)
    bench.hands.watch(bench.grabber.feature("Gain"))
    bench.write("Exposure", 50.0, wait=0.1)
    bench.grabber.set("Gamma", 2.0)
    bench.hands.watch(bench.grabber.feature("Gamma"))
    assert bench.log == [("Gain 1 → 7", NETWORK), ("Exposure 1 → 50", OPERATOR), ("Gamma 1 → 2", CAMERA)]


def test_the_operators_own_change_is_not_noted_twice_when_it_is_read(bench):
    bench.hands.watch(bench.grabber.feature("Gain"))
    bench.write("Gain", 6.0)
    bench.hands.watch(bench.grabber.feature("Gain"))
    assert bench.log == [("Gain 1 → 6", OPERATOR)]


def test_a_regulated_value_is_one_entry_that_grows(bench):
    for value in range(1, 20):
        bench.grabber.set("Gain", float(value))
        bench.hands.watch(bench.grabber.feature("Gain"))
        bench.now += 0.2
    assert bench.log == [("Gain 1 → 19", CAMERA)]


def test_another_instance_seen_through_a_selector_is_no_change(sim):
    sim.hands.watch(sim.grabber.feature("BalanceRatio"))
    sim.write("BalanceRatioSelector", "Blue")
    sim.hands.watch(sim.grabber.feature("BalanceRatio"))
    sim.write("BalanceRatio", 2.0)
    sim.write("BalanceRatioSelector", "Red")
    sim.hands.watch(sim.grabber.feature("BalanceRatio"))
    key = SettingKey("BalanceRatio", (("BalanceRatioSelector", "Blue"),))
    assert [c.key for c in sim.journal.changes if c.key.name == "BalanceRatio"] == [key]


# -- undo and redo -----------------------------------------------------------------------------------
def test_steps_are_undone_and_redone_in_order(bench):
    bench.write("Gain", 2)
    bench.write("Gamma", 3)
    bench.revert(UNDO)
    assert (bench.value("Gain"), bench.value("Gamma")) == (2, 1)
    assert bench.journal.next_text(REDO) == "Gamma 1 → 3"
    bench.revert(UNDO)
    assert bench.value("Gain") == 1
    bench.revert(REDO, times=2)
    assert (bench.value("Gain"), bench.value("Gamma")) == (2, 3)
    assert bench.journal.next_text(REDO) == ""
    assert bench.revert(REDO) == []


def test_undoing_is_in_the_log(bench):
    bench.write("Gain", 2)
    bench.revert(UNDO)
    assert [(str(c), c.cause) for c in bench.journal.changes] == [("Gain 1 → 2", ""), ("Gain 2 → 1", "Undo")]


def test_something_new_ends_what_can_be_redone(bench):
    bench.write("Gain", 2)
    bench.revert(UNDO)
    bench.write("Gamma", 3)
    assert bench.journal.next_text(REDO) == ""


def test_commands_are_noted_cannot_be_undone_and_break_nothing(sim):
    sim.write("Gain", 3.0, wait=0.01)
    sim.hands.execute("TimestampLatch")
    sim.write("Gain", 6.0, wait=0.01)
    assert [text for text, _ in sim.log] == ["Gain 0 → 3", "TimestampLatch run", "Gain 3 → 6"]
    sim.revert(UNDO)
    assert sim.value("Gain") == 3
    sim.revert(UNDO)
    assert sim.value("Gain") == 0
    assert [text for text, _ in sim.log].count("TimestampLatch run") == 1


def test_an_undo_that_is_refused_says_so_and_leaves_the_steps_before_it(bench):
    bench.write("Gain", 2)
    bench.write("Gamma", 3)
    bench.grabber.refusals["Gamma"] = FeatureError("Gamma=1: the camera answered: busy", "Gamma")
    assert bench.revert(UNDO) == ["Undo of Gamma 1 → 3: Gamma=1: the camera answered: busy"]
    assert bench.revert(UNDO) == []
    assert bench.value("Gain") == 1


def test_an_undo_on_a_camera_that_is_gone_can_be_tried_again(bench):
    bench.write("Gain", 2)
    bench.grabber.failures["Gain"] = DeviceLostError("gone")
    with pytest.raises(DeviceLostError):
        bench.revert(UNDO)
    bench.grabber.failures.clear()
    assert bench.revert(UNDO) == []
    assert bench.value("Gain") == 1


def test_undoing_brings_back_the_automatic_mode_that_a_write_took_away(sim):
    sim.write("ExposureAuto", "Continuous")
    sim.write("ExposureTime", 5000.0)
    assert sim.value("ExposureAuto") == "Off"
    sim.revert(UNDO)
    assert sim.value("ExposureAuto") == "Continuous"


def test_undoing_an_automatic_mode_brings_back_what_stood_before(sim):
    sim.write("ExposureTime", 5000.0)
    sim.write("ExposureAuto", "Continuous")
    sim.grabber.start()
    queue = sim.grabber.open_queue()
    deadline = time.monotonic() + 10
    while sim.value("ExposureTime") <= 6000:
        assert time.monotonic() < deadline
        queue.get(5)
    sim.revert(UNDO)
    assert (sim.value("ExposureAuto"), sim.value("ExposureTime")) == ("Off", 5000.0)


def test_undoing_a_white_balance_by_the_camera_brings_back_every_ratio(sim):
    def ratios():
        found = []
        for selected in ("Red", "Blue"):
            sim.grabber.write_feature("BalanceRatioSelector", selected)
            found.append(sim.value("BalanceRatio"))
        return found

    for selected, ratio in (("Red", 1.1), ("Blue", 2.2)):
        sim.grabber.write_feature("BalanceRatioSelector", selected)
        sim.grabber.write_feature("BalanceRatio", ratio)
    sim.grabber.start()
    sim.write("BalanceWhiteAuto", "Once")
    deadline = time.monotonic() + 10
    while sim.value("BalanceWhiteAuto") != "Off":
        assert time.monotonic() < deadline
        time.sleep(0.02)
    assert sim.value("BalanceRatioSelector") == "Blue"
    assert ratios()[0] == pytest.approx(1.6, rel=0.1)
    assert sim.revert(UNDO) == []
    assert ratios() == [pytest.approx(1.1), pytest.approx(2.2)]


def test_undoing_finds_the_instance_whatever_is_selected(sim):
    sim.write("BalanceRatioSelector", "Blue")
    before = sim.value("BalanceRatio")
    sim.write("BalanceRatio", 3.0)
    sim.grabber.write_feature("BalanceRatioSelector", "Red")
    red = sim.value("BalanceRatio")
    assert sim.revert(UNDO) == []
    assert (sim.value("BalanceRatioSelector"), sim.value("BalanceRatio")) == ("Red", red)
    sim.grabber.write_feature("BalanceRatioSelector", "Blue")
    assert sim.value("BalanceRatio") == before


def test_a_loaded_set_is_one_step(sim):
    before = capture(sim.grabber)
    wanted = FeatureSet(
        {
            SettingKey("OffsetX"): 64,
            SettingKey("Width"): 128,
            SettingKey("Gain"): 3.0,
            SettingKey("BalanceRatio", (("BalanceRatioSelector", "Blue"),)): 2.0,
        }
    )
    with sim.journal.within(Step("Loaded a set")):
        assert load_onto(sim.hands, wanted).settled
    assert sim.journal.next_text(UNDO) == "Loaded a set"
    assert {c.cause for c in sim.journal.changes} == {"Loaded a set"}
    assert not [c for c in sim.journal.changes if c.key.name.endswith("Selector")]
    sim.grabber.start()
    assert sim.revert(UNDO) == []
    assert sim.grabber.streaming
    sim.grabber.stop()
    assert compare(before, capture(sim.grabber)) == []
    assert sim.revert(REDO) == []
    assert (sim.value("Width"), sim.value("OffsetX"), sim.value("Gain")) == (128, 64, 3.0)


# -- made again --------------------------------------------------------------------------------------
URI = "sim:?width=64&height=64&pixel_format=RGB8"
NAMES = ["ExposureTime", "Gain", "BalanceRatioSelector", "BalanceRatio", "Gamma", "DeviceUserID"]


@pytest.fixture
def tuned(sim):
    """A camera on which an operator was at work, and its settings at the end."""
    sim.write("ExposureTime", 4000.0)
    sim.write("Gain", 3.0)
    sim.write("ExposureTime", 5000.0)
    sim.write("BalanceRatioSelector", "Blue")
    sim.write("BalanceRatio", 2.5)
    sim.write("BalanceRatioSelector", "Red")
    sim.write("BalanceRatio", 1.5)
    sim.write("Gamma", 2.0)
    sim.revert(UNDO)
    sim.write("DeviceUserID", "it's $HOME")
    sim.journal.saw(SettingKey("BlackLevel"), 1.0, 9.0, CAMERA)
    return sim


def after(camera):
    return [camera.feature(name).value for name in NAMES]


def test_the_command_line_makes_the_changes_again(tuned, capsys, monkeypatch):
    line = replay.command_line(URI, tuned.journal.changes)
    words = shlex.split(line)
    assert words[:3] == ["grabbergui", "set", URI]
    assert not [w for w in words if w.startswith(("Gamma", "BlackLevel")) or w == "ExposureTime=4000"]
    opened, create = [], sources.create

    def remembered(uri):
        opened.append(create(uri))
        monkeypatch.setattr(opened[-1], "close", lambda: None)
        return opened[-1]

    monkeypatch.setattr(sources, "create", remembered)
    assert cli.main(words[1:]) == 0
    (camera,) = opened
    monkeypatch.undo()
    try:
        assert after(camera) == after(tuned.grabber)
        camera.write_feature("BalanceRatioSelector", "Blue")
        assert camera.feature("BalanceRatio").value == 2.5
    finally:
        camera.close()
    assert "Gain = 3 dB" in capsys.readouterr().out


def test_the_program_makes_the_changes_again(tuned):
    text = replay.program(URI, tuned.journal.changes)
    assert "ExposureTime', 5000.0" in text
    text = text.replace("finally:", "    print([camera.feature(n).value for n in NAMES])\nfinally:")
    text = f"NAMES = {NAMES}\n{text}"
    ran = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, timeout=50)
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout.strip() == repr(after(tuned.grabber))


def test_commands_stand_where_they_were_run(sim):
    sim.write("Gain", 3.0)
    sim.hands.execute("TimestampLatch")
    sim.write("Gain", 6.0)
    assert replay.command_line("sim:", sim.journal.changes) == (
        "grabbergui set sim: Gain=3\ngrabbergui run sim: TimestampLatch\ngrabbergui set sim: Gain=6\n"
    )
    assert "camera.execute('TimestampLatch')" in replay.program("sim:", sim.journal.changes)


def test_nothing_changed_makes_an_empty_line_and_a_program_that_runs(bench):
    assert replay.command_line("sim:", ()) == ""
    compile(replay.program("sim:", ()), "program", "exec")


def test_notes_from_two_threads_lose_nothing(bench):
    def see(name):
        for turn in range(200):
            bench.journal.saw(SettingKey(f"{name}{turn}"), 0, 1, CAMERA)

    threads = [threading.Thread(target=see, args=(name,)) for name in "ab"]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len({c.number for c in bench.journal.changes}) == 400


# -- a connection ------------------------------------------------------------------------------------
@pytest.fixture
def served():
    """A camera that is on a network too, and a connection to it as the window makes one."""
    camera = sources.create(URI)
    camera.open()
    link = Connection(lambda uri: SharedGrabber(camera))
    link.connect_to("sim:", start=False)
    deadline = time.monotonic() + 10
    while link.state is not LinkState.OPEN:
        assert time.monotonic() < deadline
        time.sleep(0.005)
    yield camera, link.source
    link.disconnect()
    assert link.wait_closed(10)
    camera.close()


def noted(source, *wanted):
    deadline = time.monotonic() + 5
    while not set(wanted) <= {(str(c), c.origin) for c in source.journal.changes}:
        assert time.monotonic() < deadline, source.journal.changes
        time.sleep(0.005)


def test_on_a_served_camera_the_log_tells_the_operator_from_the_network(served):
    camera, source = served
    told = threading.Event()
    source.features.feature_changed.connect(lambda feature: told.set())
    source.features.watch(["Gain", "Gamma"])
    assert told.wait(5)
    source.features.write("Gain", 3.0)
    noted(source, ("Gain 0 → 3", OPERATOR))
    time.sleep(CONSEQUENCES)  # what comes sooner may be a consequence of the operator's own change
    camera.write_feature("Gamma", 2.0)
    noted(source, ("Gamma 1 → 2", NETWORK))
    assert source.journal.next_text(UNDO) == "Gain 0 → 3"
    source.features.run(lambda: revert(source.hands, UNDO))
    noted(source, ("Gain 3 → 0", OPERATOR))
    assert camera.feature("Gamma").value == 2.0


def test_undo_comes_behind_the_writes_that_wait(served):
    camera, source = served
    source.features.write("Gain", 3.0)
    source.features.write("Gain", 6.0)
    done = threading.Event()
    source.features.run(lambda: revert(source.hands, UNDO), done=lambda problems: done.set())
    assert done.wait(5)
    assert camera.feature("Gain").value == 0

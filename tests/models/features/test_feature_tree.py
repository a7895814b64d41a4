import threading
import time
from dataclasses import replace

import pytest

from fakes import ScriptedGrabber
from grabbergui import sources
from grabbergui.core.errors import AckTimeoutError, DeviceLostError, FeatureValueError
from grabbergui.core.features import AccessMode, Category, Feature, FeatureKind
from grabbergui.core.settings import SettingKey, ValueChange, WriteResult
from grabbergui.models.features.shown import tooltip_html
from grabbergui.models.features.tree import FeatureTreeModel
from grabbergui.models.features.worker import FeatureWorker
from patience import PATIENCE, until


def number(name, value=1.0, **more):
    fields = {"minimum": 0.0, "maximum": 100.0, "access": AccessMode.READ_WRITE, **more}
    return Feature(name=name, kind=FeatureKind.FLOAT, value=value, **fields)


class Stage:
    """A model on a scripted grabber, and all its signals."""

    def __init__(self, *features):
        self.grabber = ScriptedGrabber(features)
        self.worker = FeatureWorker("worker")
        self.model = FeatureTreeModel(self.grabber, self.worker)
        self.changed, self.errors = [], []
        self.model.feature_changed.connect(self.changed.append)
        self.model.failed.connect(self.errors.append)

    def settle(self):
        """Wait until the worker has nothing to do, delayed writes included."""
        for delay in (0.06, 0, 0):
            idle = threading.Event()
            self.worker.submit(lambda: None, done=lambda _, idle=idle: idle.set(), delay=delay)
            assert idle.wait(PATIENCE)

    def values(self, name):
        return [feature.value for feature in self.changed if feature.name == name]

    def written(self, name):
        return [value for written, value, _ in self.grabber.writes if written == name]


@pytest.fixture
def stage():
    stages = []

    def build(*features):
        stages.append(Stage(*features))
        return stages[-1]

    yield build
    for stage in stages:
        stage.grabber.gate.set()
        stage.model.close()
        assert stage.worker.close()


def test_making_a_model_reads_nothing(stage):
    s = stage(number("ExposureTime"), number("Gain"))
    s.settle()
    assert s.grabber.reads == []
    assert s.model.feature("Gain") is None
    assert s.model.description("Gain").kind is FeatureKind.FLOAT
    assert s.model.description("Nothing") is None


def test_favourites_are_features_of_this_camera(stage):
    assert stage(number("GainRaw"), number("ExposureTimeAbs"), number("Width")).model.favourites == (
        "ExposureTimeAbs",
        "GainRaw",
    )


def test_requested_features_are_read_on_the_worker_and_reported_even_if_unchanged(stage):
    s = stage(number("A"), number("B"))
    s.model.request(["A", "B"])
    s.model.request(["A"])
    s.settle()
    s.model.request(["A"])
    s.settle()
    assert s.values("A") == [1.0, 1.0]
    assert s.values("B") == [1.0]
    assert s.grabber.threads == {"worker"}
    assert s.model.feature("A") == s.grabber.known["A"]


class RemoteScript(ScriptedGrabber):
    """Reads up to four features by one request."""

    reads_at_once = 4

    def __init__(self, features):
        super().__init__(features)
        self.requests = []

    def read_features(self, names):
        self.requests.append(len(names))
        return super().read_features(names)


def test_features_of_a_remote_camera_are_read_by_few_requests(stage, monkeypatch):
    monkeypatch.setattr("test_feature_tree.ScriptedGrabber", RemoteScript)
    s = stage(*(number(f"F{n}", float(n)) for n in range(6)))
    s.model.request([f"F{n}" for n in range(6)])
    s.settle()
    assert s.grabber.requests == [4, 2]
    assert [(feature.name, feature.value) for feature in s.changed] == [(f"F{n}", float(n)) for n in range(6)]


def test_an_unreadable_feature_does_not_affect_those_read_with_it(stage, monkeypatch):
    monkeypatch.setattr("test_feature_tree.ScriptedGrabber", RemoteScript)
    s = stage(*(number(f"F{n}") for n in range(6)))
    s.grabber.failures["F1"] = FeatureValueError("it burns", "F1")
    s.model.request([f"F{n}" for n in range(6)])
    s.settle()
    assert s.grabber.requests == [4, 2]
    assert sorted(feature.name for feature in s.changed) == [f"F{n}" for n in range(6)]
    assert s.model.feature("F1").problem == "it burns"
    assert s.errors == []


def test_a_lost_remote_device_is_reported_once(stage, monkeypatch):
    monkeypatch.setattr("test_feature_tree.ScriptedGrabber", RemoteScript)
    s = stage(*(number(f"F{n}") for n in range(6)))
    s.grabber.failures = {f"F{n}": DeviceLostError("gone") for n in range(6)}
    s.model.request([f"F{n}" for n in range(6)])
    s.settle()
    assert len(s.errors) == 1


def test_a_write_overtakes_a_long_reading(stage):
    features = [number(f"F{n}") for n in range(200)]
    s = stage(*features)
    s.grabber.delays = {feature.name: 0.002 for feature in features}
    first = threading.Event()
    s.model.feature_changed.connect(lambda feature: first.set())
    s.model.request([feature.name for feature in features])
    assert first.wait(PATIENCE)
    s.model.write("F199", 5.0)
    deadline = time.monotonic() + PATIENCE
    while not s.grabber.writes and time.monotonic() < deadline:
        time.sleep(0.001)
    assert len(s.grabber.reads) < 60


def test_only_watched_features_are_read_again(stage):
    s = stage(number("A"), number("B"))
    s.model.watch(["A"])
    s.settle()
    assert s.values("A") == [1.0]
    s.grabber.set("A", 2.0)
    s.grabber.set("B", 3.0)
    s.settle()
    assert s.values("A") == [1.0, 2.0]
    assert "B" not in s.grabber.reads
    s.model.watch(["B"])
    s.settle()
    assert s.values("B") == [3.0]


def test_a_feature_that_changed_while_unwatched_is_read_when_watched_again(stage):
    s = stage(number("A"), number("B"))
    s.model.watch(["A", "B"])
    s.settle()
    s.model.watch(["B"])
    s.grabber.set("A", 9.0)
    s.settle()
    reads = s.grabber.reads.count("B")
    s.model.watch(["A", "B"])
    s.settle()
    assert s.values("A") == [1.0, 9.0]
    assert s.grabber.reads.count("B") == reads


def test_a_read_dropped_by_unwatching_happens_when_watched_again(stage):
    s = stage(number("A"), number("B"))
    s.model.watch(["A"])
    s.settle()
    s.grabber.gate.clear()
    s.model.request(["B"])
    s.grabber.set("A", 9.0)
    s.model.watch([])
    s.grabber.gate.set()
    s.settle()
    s.model.watch(["A"])
    s.settle()
    assert s.values("A")[-1] == 9.0


def test_a_notification_that_changed_nothing_is_not_reported(stage):
    s = stage(number("A"))
    s.model.watch(["A"])
    s.settle()
    s.grabber.features_changed.emit(frozenset(["A"]))
    s.settle()
    assert s.grabber.reads == ["A", "A"]
    assert s.values("A") == [1.0]


def test_the_automatic_mode_of_a_watched_feature_is_followed(stage):
    auto = Feature(name="GainAuto", kind=FeatureKind.ENUMERATION, access=AccessMode.READ_WRITE, value="Off")
    s = stage(number("Gain", auto="GainAuto"), auto)
    s.model.watch(["Gain"])
    s.settle()
    s.grabber.set("GainAuto", "Continuous")
    s.settle()
    assert s.values("GainAuto") == ["Off", "Continuous"]
    s.model.watch([])
    s.model.watch(["Gain"])
    s.grabber.set("GainAuto", "Once")
    s.settle()
    assert s.values("GainAuto")[-1] == "Once"


def test_writes_are_at_most_60_a_second_and_the_last_one_is_sent(stage):
    s = stage(number("Gain"))
    begun = time.monotonic()
    s.model.write("Gain", 0.0)
    until(lambda: s.grabber.writes)  # the first is sent at once
    for step in range(1, 60):
        s.model.write("Gain", float(step))
        time.sleep(0.003)
    s.settle()
    times = [moment for _, _, moment in s.grabber.writes]
    assert s.written("Gain")[0] == 0.0
    assert s.written("Gain")[-1] == 59.0
    # One that a busy machine delayed may be close to the next: the rate counts, not each pause.
    assert 2 <= len(times) <= 60 * (times[-1] - begun) + 2
    assert s.values("Gain")[-1] == 59.0


def test_a_write_waits_for_one_read_at_most(stage):
    """A camera's answers may take milliseconds each; what the operator does comes first."""
    names = [f"F{index}" for index in range(20)]
    s = stage(number("Gain"), *(number(name) for name in names))
    s.grabber.gate.clear()
    s.model.request(names)
    read_before = []
    write = s.grabber.write_feature

    def note_and_write(name, value):
        read_before.extend(s.grabber.reads)
        return write(name, value)

    s.grabber.write_feature = note_and_write
    s.model.write("Gain", 5.0)
    s.grabber.gate.set()
    s.settle()
    assert [name for name in read_before if name in names] == names[:1]
    assert set(s.grabber.reads) >= set(names)


def test_while_a_newer_value_waits_the_older_one_is_not_shown(stage):
    s = stage(number("Gain"))
    s.grabber.gate.clear()
    s.model.request(["Gain"])
    s.model.write("Gain", 5.0)
    s.grabber.gate.set()
    s.settle()
    assert s.values("Gain") == [5.0]


def test_writes_keep_their_order_among_features_and_commands(stage):
    command = Feature(name="UserSetSave", kind=FeatureKind.COMMAND, access=AccessMode.WRITE_ONLY)
    s = stage(number("Gain"), number("Other"), command)
    order = []
    s.grabber.on_write = lambda name, value: order.append(name) or value
    s.grabber.execute = lambda name: order.append(name)
    s.model.write("Gain", 1.0)
    s.settle()
    s.model.write("Gain", 2.0)
    s.model.write("Gain", 3.0)
    s.model.write("Other", 4.0)
    s.model.execute("UserSetSave")
    s.settle()
    assert order == ["Gain", "Gain", "Other", "UserSetSave"]


def test_a_refused_write_fails_and_the_cameras_truth_is_reported(stage):
    s = stage(number("Gain", 7.0))
    s.model.write("Gain", 1000.0)
    s.settle()
    assert isinstance(s.errors[0], FeatureValueError)
    assert "Gain" in str(s.errors[0])
    assert s.values("Gain") == [7.0]


def test_the_value_that_the_camera_accepted_is_reported(stage):
    s = stage(number("Gain"))
    s.grabber.on_write = lambda name, value: round(value)
    s.model.write("Gain", 2.7)
    s.settle()
    assert s.values("Gain") == [3]


def test_a_held_feature_waits_and_is_reported_on_release(stage):
    s = stage(number("Gain"))
    s.model.watch(["Gain"])
    s.settle()
    s.model.hold("Gain")
    s.grabber.set("Gain", 8.0)
    s.settle()
    assert s.values("Gain") == [1.0]
    assert s.model.feature("Gain").value == 8.0
    s.model.release("Gain")
    assert s.values("Gain") == [1.0, 8.0]
    s.model.hold("Gain")
    s.model.release("Gain")
    assert s.values("Gain") == [1.0, 8.0]


def test_a_command_runs_and_its_errors_are_reported(stage):
    command = Feature(name="TriggerSoftware", kind=FeatureKind.COMMAND, access=AccessMode.WRITE_ONLY)
    s = stage(command, number("Gain"))
    s.model.execute("TriggerSoftware")
    s.model.execute("Gain")
    s.settle()
    assert s.grabber.commands == ["TriggerSoftware"]
    assert "Gain is no command" in str(s.errors[0])


def test_one_odd_feature_does_not_affect_the_others(stage, caplog):
    s = stage(number("A"), number("B"), number("C"))
    s.grabber.failures["B"] = RuntimeError("odd node")
    s.model.request(["A", "B", "C", "Unknown"])
    s.settle()
    assert [feature.name for feature in s.changed] == ["A", "B", "C", "Unknown"]
    assert s.changed[1].access is AccessMode.NOT_AVAILABLE
    assert "odd node" in s.changed[1].problem
    assert "Unknown" in s.changed[3].problem
    assert "odd node" in caplog.text


def test_a_timeout_keeps_the_last_known_value(stage):
    s = stage(number("A", 4.0))
    s.model.request(["A"])
    s.settle()
    s.grabber.failures["A"] = AckTimeoutError("no answer")
    s.model.request(["A"])
    s.settle()
    assert s.values("A") == [4.0, 4.0]
    assert [str(error) for error in s.errors] == ["no answer"]


def test_a_lost_device_is_reported_once(stage):
    features = [number(f"F{n}") for n in range(50)]
    s = stage(*features)
    s.grabber.failures = {feature.name: DeviceLostError("gone") for feature in features}
    s.model.request([feature.name for feature in features])
    s.settle()
    assert [str(error) for error in s.errors] == ["gone"]


def test_reload_takes_the_new_tree(stage):
    s = stage(number("A"))
    reported = []
    s.model.structure_changed.connect(lambda: reported.append(s.model.root))
    s.model.request(["A"])
    s.settle()
    s.grabber.known = {"Gain": number("Gain")}
    s.grabber.tree = Category("Root", members=(number("Gain"),))
    s.model.reload()
    s.settle()
    assert reported == [s.grabber.tree]
    assert s.model.favourites == ("Gain",)
    assert s.model.feature("A") is None


def test_a_control_is_released_after_the_tree_was_reloaded(stage):
    s = stage(number("Gain"))
    s.model.hold("Gain")
    s.model.request(["Gain"])
    s.settle()
    s.model.reload()
    s.settle()
    s.model.release("Gain")
    assert s.changed == [], "what was held back is out of date"


def test_closing_sends_waiting_writes_and_emits_nothing(stage):
    s = stage(number("Gain"))
    s.model.write("Gain", 1.0)
    s.settle()
    reported = len(s.changed)
    s.model.write("Gain", 2.0)
    s.model.write("Gain", 3.0)
    s.model.close()
    s.model.close()
    s.model.write("Gain", 4.0)
    s.model.execute("Gain")
    s.grabber.set("Gain", 9.0)
    assert s.worker.close()
    assert s.written("Gain")[-1] == 3.0
    assert len(s.changed) == reported
    assert s.errors == []


def test_features_returned_by_a_write_are_not_read_again(stage):
    """Each step of a slider on a remote camera cost two requests."""
    s = stage(number("Gain"), number("ExposureTime"))
    s.model.watch(["Gain", "ExposureTime"])
    s.settle()
    write = s.grabber.write_feature

    def write_and_report(name, value):
        feature = write(name, value)
        s.grabber.features_changed.emit(frozenset({"Gain", "ExposureTime"}))
        return feature

    s.grabber.write_feature = write_and_report
    reads = len(s.grabber.reads)
    s.model.write("Gain", 2.0)
    s.settle()
    again = s.grabber.reads[reads:]
    assert s.values("Gain")[-1] == 2.0
    assert again.count("ExposureTime") == 1
    before = again.count("Gain")
    assert before == 1  # for the value before it
    s.grabber.features_changed.emit(frozenset({"Gain"}))  # somebody else
    s.settle()
    assert s.grabber.reads[reads:].count("Gain") == before + 1


def test_companions_and_consequences_returned_by_a_write_are_not_read_again(stage):
    """A window on a remote camera read the mode and the height after each write, a request each."""
    s = stage(number("Gain"), number("Height"), number("Offset"), number("Width"))
    watched = ["Gain", "Height", "Offset", "Width"]
    s.model.watch(watched)
    s.settle()

    def write_and_return_all(key, value):
        s.grabber.features_changed.emit(frozenset(watched))
        height, offset = (replace(s.grabber.known[name], value=7.0) for name in ("Height", "Offset"))
        s.grabber.known |= {"Height": height, "Offset": offset, "Width": number("Width", 8.0)}
        written = number("Gain", value)
        changes = [ValueChange(SettingKey(name), 1.0, 7.0) for name in ("Height", "Offset")]
        return WriteResult(
            written, (changes[0], ValueChange(key, 1.0, value)), (changes[1],), (height, offset)
        )

    s.grabber.write_setting = write_and_return_all
    s.grabber.reads.clear()
    s.model.write("Gain", 2.0)
    s.settle()

    assert [s.values(name)[-1] for name in watched] == [2.0, 7.0, 7.0, 8.0]
    assert s.grabber.reads == ["Width"]


def test_features_changed_by_a_refused_write_are_read(stage):
    s = stage(number("Gain"), number("Auto"))
    s.model.watch(["Gain", "Auto"])
    s.settle()

    def change_and_refuse(key, value):
        s.grabber.known["Auto"] = number("Auto", 0.0)
        s.grabber.features_changed.emit(frozenset({"Auto"}))
        raise FeatureValueError("no", "Gain")

    s.grabber.write_setting = change_and_refuse
    s.model.write("Gain", 2.0)
    s.settle()

    assert s.values("Auto")[-1] == 0.0
    assert len(s.errors) == 1


def test_the_shown_instance_is_written_whatever_others_select():
    camera = sources.create("sim:?width=64&height=48&pixel_format=RGB8")
    camera.open()
    worker = FeatureWorker("worker")
    try:
        model = FeatureTreeModel(camera, worker)
        shown = {}
        model.feature_changed.connect(lambda feature: shown.__setitem__(feature.name, feature))
        model.write("BalanceRatioSelector", "Red")
        model.write("BalanceRatio", 1.5)  # before the selector's own write is known to be done
        until(lambda: "BalanceRatio" in shown, "the first write")
        camera.write_feature("BalanceRatioSelector", "Green")  # somebody else; nothing here looks at it
        green = camera.feature("BalanceRatio").value
        shown.clear()
        model.write("BalanceRatio", 1.75)
        until(lambda: "BalanceRatio" in shown, "the second write")
        assert camera.feature("BalanceRatioSelector").value == "Green"
        assert camera.feature("BalanceRatio").value == green
        red = SettingKey("BalanceRatio", (("BalanceRatioSelector", "Red"),))
        assert camera.read_setting(red).value == pytest.approx(1.75)
        model.close()
    finally:
        assert worker.close()
        camera.close()


def test_a_feature_locked_only_by_the_stream_is_offered_as_writable(stage):
    locked = AccessMode.READ_ONLY
    s = stage(number("Width", access=locked), number("Temperature", access=locked))
    s.grabber.pauses_for = lambda name: name == "Width"
    s.grabber.start()
    s.model.request(["Width", "Temperature"])
    s.settle()
    width, temperature = s.model.feature("Width"), s.model.feature("Temperature")
    assert (width.access, width.pauses_stream) == (AccessMode.READ_WRITE, True)
    assert (temperature.access, temperature.pauses_stream) == (locked, False)
    assert "pauses the stream" in tooltip_html(width)
    assert "pauses the stream" not in tooltip_html(temperature)

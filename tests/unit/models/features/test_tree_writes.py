"""Values and commands that the feature tree sends to a camera, and what it reads of them again."""

import threading
from dataclasses import replace

import pytest

from grabbergui import sources
from grabbergui.core.errors import FeatureValueError
from grabbergui.core.features import AccessMode, Feature, FeatureKind
from grabbergui.core.settings import SettingKey, ValueChange, WriteResult
from grabbergui.models.features.feature_text import tooltip
from grabbergui.models.features.tree import FeatureTreeModel
from grabbergui.models.features.worker import FeatureWorker
from patience import PATIENCE, until
from tree_bench import number


def test_a_write_overtakes_a_long_reading(stage):
    features = [number(f"F{n}") for n in range(200)]
    s = stage(*features)
    s.grabber.delays = {feature.name: 0.002 for feature in features}
    first = threading.Event()
    s.model.feature_changed.connect(lambda feature: first.set())
    s.model.request([feature.name for feature in features])
    assert first.wait(PATIENCE)
    s.model.write("F199", 5.0)
    until(lambda: s.grabber.writes)
    assert len(s.grabber.reads) < 60


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


def test_a_command_runs_and_its_errors_are_reported(stage):
    command = Feature(name="TriggerSoftware", kind=FeatureKind.COMMAND, access=AccessMode.WRITE_ONLY)
    s = stage(command, number("Gain"))
    s.model.execute("TriggerSoftware")
    s.model.execute("Gain")
    s.settle()
    assert s.grabber.commands == ["TriggerSoftware"]
    assert "Gain is no command" in str(s.errors[0])


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
    assert "pauses the stream" in tooltip(width)
    assert "pauses the stream" not in tooltip(temperature)

"""What the feature tree reads from a camera, when, and what it reports."""

from grabbergui.core.errors import AckTimeoutError, DeviceLostError, FeatureValueError
from grabbergui.core.features import AccessCondition, AccessMode, Category, Feature, FeatureKind
from tree_bench import RemoteScript, number


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


def test_what_hides_a_feature_is_found_out_on_request_only(stage):
    s = stage(number("A"))
    hidden = (AccessCondition("TriggerMode", "Off", ("On",)),)
    s.grabber.conditions = lambda name: hidden
    s.model.explain("A")
    s.settle()
    assert s.changed == [], "it was never read"
    s.model.request(["A"])
    s.settle()
    assert s.model.feature("A").conditions == ()
    s.model.explain("A")
    s.settle()
    assert s.changed[-1].conditions == hidden


def test_features_of_a_remote_camera_are_read_by_few_requests(stage):
    s = stage(*(number(f"F{n}", float(n)) for n in range(6)), kind=RemoteScript)
    s.model.request([f"F{n}" for n in range(6)])
    s.settle()
    assert s.grabber.requests == [4, 2]
    assert [(feature.name, feature.value) for feature in s.changed] == [(f"F{n}", float(n)) for n in range(6)]


def test_an_unreadable_feature_does_not_affect_those_read_with_it(stage):
    s = stage(*(number(f"F{n}") for n in range(6)), kind=RemoteScript)
    s.grabber.failures["F1"] = FeatureValueError("it burns", "F1")
    s.model.request([f"F{n}" for n in range(6)])
    s.settle()
    assert s.grabber.requests == [4, 2]
    assert sorted(feature.name for feature in s.changed) == [f"F{n}" for n in range(6)]
    assert s.model.feature("F1").problem == "it burns"
    assert s.errors == []


def test_a_lost_remote_device_is_reported_once(stage):
    s = stage(*(number(f"F{n}") for n in range(6)), kind=RemoteScript)
    s.grabber.failures = {f"F{n}": DeviceLostError("gone") for n in range(6)}
    s.model.request([f"F{n}" for n in range(6)])
    s.settle()
    assert len(s.errors) == 1


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
    s.grabber.tree = Category("Root", members=(number("Gain"), number("A")))
    s.model.reload()
    s.settle()
    s.model.release("Gain")
    assert s.changed == [], "what was held back is out of date"

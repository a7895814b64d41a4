"""Settings as text, read and written as one step; several of them brought to given values."""

import threading
from dataclasses import replace

import pytest

from fakes import ScriptedGrabber
from grabbergui import sources
from grabbergui.core.errors import FeatureAccessError, FeatureError, UsageError
from grabbergui.core.feature_instances import MAX_INSTANCES, instances, instances_of
from grabbergui.core.features import AccessMode, EnumEntry, Feature, FeatureKind
from grabbergui.core.settings import MOST_CHANGED, SettingKey, return_text, same_value
from grabbergui.core.settle import BATCH, MAX_PASSES, Settled, settle

RED, GREEN, BLUE = (
    SettingKey("BalanceRatio", (("BalanceRatioSelector", entry),)) for entry in ("Red", "Green", "Blue")
)


@pytest.fixture
def camera():
    grabber = sources.create("sim:?width=64&height=48&pixel_format=RGB8")
    grabber.open()
    yield grabber
    grabber.close()


@pytest.mark.parametrize("key", [SettingKey("Width"), RED, SettingKey("A", (("S", "1"), ("T", "x y")))])
def test_a_key_is_read_as_it_is_written(key):
    assert SettingKey.parse(str(key)) == key


@pytest.mark.parametrize("text", ["", "A B", "A[", "A[S]", "A[=1]", "[S=1]"])
def test_an_invalid_key_is_refused(text):
    with pytest.raises(UsageError):
        SettingKey.parse(text)


@pytest.mark.parametrize(
    ("text", "key", "value"),
    [
        ("Gain=3", SettingKey("Gain"), "3"),
        ("BalanceRatio[BalanceRatioSelector=Red]=1.5", RED, "1.5"),
        (" DeviceUserID =a=b[c]", SettingKey("DeviceUserID"), "a=b[c]"),
    ],
)
def test_an_assignment_has_a_key_with_its_selectors(text, key, value):
    assert SettingKey.parse_assignment(text) == (key, value)


def test_a_name_alone_is_no_assignment():
    assert SettingKey.parse_assignment("Gain[GainSelector=All]") is None


def test_selectors_are_restored(camera):
    camera.write_feature("BalanceRatioSelector", "Green")
    camera.write_setting(BLUE, 1.75)
    assert camera.read_setting(BLUE).value == 1.75
    with pytest.raises(FeatureError):
        camera.write_setting(BLUE, 1e9)
    assert camera.feature("BalanceRatioSelector").value == "Green"


def test_a_write_returns_everything_that_it_changed(camera):
    camera.write_feature("ExposureAuto", "Continuous")
    result = camera.write_setting(SettingKey("ExposureTime"), 200_000.0)
    assert [(change.key.name, change.after) for change in result.written] == [
        ("ExposureAuto", "Off"),
        ("ExposureTime", 200_000.0),
    ]
    (rate,) = [change for change in result.consequences if change.key.name == "AcquisitionFrameRate"]
    assert rate.after == camera.feature("AcquisitionFrameRate").value < rate.before


def test_no_caller_sees_or_changes_anothers_selection(camera):
    """One writes red, one green, one blue, one looks at what is selected: all at once."""
    camera.write_feature("BalanceRatioSelector", "Green")
    wrong, rounds = [], range(60)

    def write(key, base):
        for number in rounds:
            value = base + number / 100
            after = camera.write_setting(key, value).feature.value
            if abs(after - value) > 1e-3 or abs(camera.read_setting(key).value - value) > 1e-3:
                wrong.append((str(key), value, after))

    def look():
        seen = {camera.feature("BalanceRatioSelector").value for _ in rounds}
        wrong.extend(seen - {"Green"})

    writes = ((RED, 1), (GREEN, 2), (BLUE, 3))
    work = [threading.Thread(target=write, args=arguments) for arguments in writes]
    work.append(threading.Thread(target=look))
    for thread in work:
        thread.start()
    for thread in work:
        thread.join()
    assert wrong == []


WIDTH, OFFSET, GAIN, AUTO = map(SettingKey, ("Width", "OffsetX", "Gain", "GainAuto"))


def number(name, value, maximum=100):
    return Feature(
        name=name,
        kind=FeatureKind.INTEGER,
        access=AccessMode.READ_WRITE,
        value=value,
        minimum=0,
        maximum=maximum,
    )


def choice(name, value, *names):
    entries = tuple(EnumEntry(entry) for entry in names)
    return Feature(
        name=name, kind=FeatureKind.ENUMERATION, access=AccessMode.READ_WRITE, value=value, entries=entries
    )


def test_the_instances_of_a_feature_are_all_combinations_of_its_selectors_entries():
    index = replace(number("Index", 2, maximum=6), minimum=2, increment=2)
    channel = choice("Channel", "Red", "Red", "Blue")
    grabber = ScriptedGrabber([index, channel])
    assert instances(grabber, ["Index", "Channel"]) == (
        [(("Index", i), ("Channel", c)) for i in ("2", "4", "6") for c in ("Red", "Blue")],
        "",
    )
    grabber.set("Channel", access=AccessMode.READ_ONLY)
    found, reason = instances(grabber, ["Index", "Channel"])
    assert found == [(("Index", "2"), ("Channel", "Red"))] and "cannot be changed" in reason
    grabber.known["Channel"] = replace(channel, value=None)
    assert instances(grabber, ["Index", "Channel"]) == ([], "")


@pytest.mark.parametrize(
    ("maximum", "kept"), [(MAX_INSTANCES - 1, MAX_INSTANCES), (MAX_INSTANCES, 1), (2**62, 1)]
)
def test_of_too_many_instances_only_the_selected_one_is_kept(maximum, kept):
    grabber = ScriptedGrabber([number("LUTIndex", 5, maximum=maximum)])
    found, reason = instances(grabber, ["LUTIndex"])
    assert len(found) == kept
    assert (found == [(("LUTIndex", "5"),)], f"more than {MAX_INSTANCES}" in reason) == (kept == 1, kept == 1)


class Reports(list):
    def __call__(self, key, settled, value, error, feature):
        self.append((str(key), settled, value))


@pytest.fixture
def reports():
    return Reports()


@pytest.fixture
def region():
    """A sensor of 100 columns: the offset has the room that the width leaves."""
    grabber = ScriptedGrabber([number("Width", 100), number("OffsetX", 0, maximum=0)])

    def follow(name, value):
        if name == "Width":
            grabber.set("OffsetX", maximum=100 - value)
        return value

    grabber.on_write = follow
    return grabber


def written(grabber):
    return [(name, value) for name, value, _ in grabber.writes]


def test_a_value_that_does_not_fit_yet_is_tried_again_after_the_others(region, reports):
    assert settle(region, {OFFSET: 40, WIDTH: 60}, report=reports) == {}
    assert (region.known["OffsetX"].value, region.known["Width"].value) == (40, 60)
    assert [entry[:2] for entry in reports] == [
        ("OffsetX", Settled.REFUSED),
        ("Width", Settled.WRITTEN),
        ("OffsetX", Settled.WRITTEN),
    ]


def test_a_value_that_never_fits_is_returned_with_the_reason(region, reports):
    problems = settle(region, {OFFSET: 70, WIDTH: 60}, report=reports)
    assert list(problems) == [OFFSET]
    assert "OffsetX" in problems[OFFSET] and "40" in problems[OFFSET]
    assert reports[-1] == ("OffsetX", Settled.REFUSED, None)


def test_equal_values_are_not_written(region, reports):
    assert settle(region, {WIDTH: "100", OFFSET: 0}, report=reports) == {}
    assert region.writes == []
    assert reports == [("Width", Settled.WRITTEN, 100), ("OffsetX", Settled.WRITTEN, 0)]


def test_a_rounded_value_is_not_written_forever(reports):
    grabber = ScriptedGrabber([number("Width", 0)])
    grabber.on_write = lambda name, value: value // 8 * 8
    problems = settle(grabber, {WIDTH: 63}, report=reports)
    assert problems == {WIDTH: "Width is 56 instead of 63"}
    assert written(grabber) == [("Width", 63)] * 2
    assert reports[-1] == ("Width", Settled.DIFFERENT, 56)


def test_a_value_that_a_later_write_changed_is_written_again(reports):
    grabber = ScriptedGrabber([number("Width", 1), number("Gain", 1)])

    def disturb(name, value):
        if name == "Gain" and len(grabber.writes) < 4:
            grabber.set("Width", 5)
        return value

    grabber.on_write = disturb
    assert settle(grabber, {WIDTH: 7, GAIN: 2}, report=reports) == {}
    assert written(grabber) == [("Width", 7), ("Gain", 2), ("Width", 7)]
    assert reports[-1] == ("Width", Settled.WRITTEN, 7)


def test_a_number_beyond_any_float_is_refused():
    grabber = ScriptedGrabber([replace(number("Gain", 1), kind=FeatureKind.FLOAT, value=1.5)])
    assert "Gain" in settle(grabber, {SettingKey("Gain"): "1" * 400})[SettingKey("Gain")]


def test_two_conflicting_settings_come_to_an_end():
    grabber = ScriptedGrabber([number("Width", 1), number("Gain", 1)])
    other = {"Width": "Gain", "Gain": "Width"}

    def fight(name, value):
        grabber.set(other[name], len(grabber.writes) % 90 + 9)
        return value

    grabber.on_write = fight
    assert settle(grabber, {WIDTH: 7, GAIN: 2})
    assert len(grabber.writes) <= 2 * (MAX_PASSES + 1)


def test_a_wanted_mode_takes_precedence_over_the_value_it_regulates():
    grabber = ScriptedGrabber([number("Gain", 1), choice("GainAuto", "Off", "Off", "Continuous")])
    assert settle(grabber, {AUTO: "Continuous", GAIN: 50}) == {}
    assert written(grabber) == [("GainAuto", "Continuous")]


def test_a_value_that_a_wanted_mode_regulates_is_no_problem_beside_one_that_is_refused():
    """It is written once another is refused, in case that one needs it; its mode may then refuse it."""
    grabber = ScriptedGrabber(
        [number("Gain", 1), choice("GainAuto", "Off", "Off", "Continuous"), number("Width", 1)]
    )
    grabber.refusals = {name: FeatureAccessError("is locked", name) for name in ("Gain", "Width")}
    assert settle(grabber, {AUTO: "Continuous", GAIN: 50, WIDTH: 7}) == {WIDTH: "is locked"}
    assert ("Gain", 50) in written(grabber)


def test_modes_are_written_after_the_values_that_they_control():
    grabber = ScriptedGrabber([choice("GainAuto", "Continuous", "Off", "Continuous"), number("Gain", 1)])
    assert settle(grabber, {AUTO: "Off", GAIN: 50}) == {}
    assert written(grabber) == [("Gain", 50), ("GainAuto", "Off")]


def test_a_mode_that_regulates_once_may_be_off_again():
    grabber = ScriptedGrabber([choice("GainAuto", "Off", "Off", "Once")])
    grabber.on_write = lambda name, value: "Off"
    assert settle(grabber, {AUTO: "Once"}) == {}
    assert written(grabber) == [("GainAuto", "Once")]


def test_a_reluctant_value_is_written_only_if_another_needs_it(region):
    assert settle(region, {WIDTH: 60}, reluctantly=[WIDTH]) == {}
    assert region.writes == []
    assert settle(region, {OFFSET: 40, WIDTH: 60}, reluctantly=[WIDTH]) == {}
    assert written(region) == [("OffsetX", 40), ("Width", 60), ("OffsetX", 40)]


def test_once_cancelled_nothing_more_is_written(region):
    assert settle(region, {WIDTH: 60, OFFSET: 40}, cancelled=lambda: bool(region.writes)) == {}
    assert written(region) == [("Width", 60)]


def test_a_feature_that_became_unavailable_is_reported():
    grabber = ScriptedGrabber([number("Width", 1)])
    grabber.known["Width"] = replace(grabber.known["Width"], value=None, access=AccessMode.NOT_AVAILABLE)
    problems = settle(grabber, {WIDTH: 7, SettingKey("Nothing"): 1})
    assert set(problems) == {WIDTH, SettingKey("Nothing")}


def test_a_selector_that_is_wanted_itself_is_not_restored_to_what_it_was(reports):
    grabber = ScriptedGrabber([choice("Selector", "E0", "E0", "E1", "E2"), number("Gain", 1)])
    wanted = {SettingKey("Selector"): "E1", SettingKey("Gain", (("Selector", "E2"),)): 5}
    assert settle(grabber, wanted, report=reports) == {}
    assert grabber.known["Selector"].value == "E1"
    assert {settled for _, settled, _ in reports} == {Settled.WRITTEN}


def test_other_callers_get_their_turn_between_batches_and_see_restored_selectors():
    entries = [f"E{index}" for index in range(2 * BATCH + 1)]
    grabber = ScriptedGrabber([choice("Selector", "E0", *entries), number("Gain", 1)])
    wanted = {SettingKey("Gain", (("Selector", entry),)): 1 for entry in entries}
    assert settle(grabber, wanted) == {}
    assert grabber.known["Selector"].value == "E0"
    back = [value for name, value, _ in grabber.writes if (name, value) == ("Selector", "E0")]
    assert len(back) == 2 * 3, "once for each batch, in writing and in looking again"


def test_a_return_is_described_by_what_differs():
    assert return_text([]) == "set as before"
    assert return_text(["Gain: busy", "Width: 8"]) == "but not as before: Gain: busy; Width: 8"
    changed = [f"F{number}" for number in range(MOST_CHANGED)]
    listed = f"set as before; changed meanwhile, not by us: {'; '.join(changed)}"
    assert return_text([], changed) == listed
    assert return_text([], [*changed, "G", "H"]) == f"{listed}; and 2 more"


@pytest.mark.parametrize(
    ("first", "second", "same"),
    [
        (1.0, 1.0000009, True),
        (1.0, 1.000002, False),
        (1e-9, 2e-9, False),
        ("0x1F", 31, True),
        ("off", False, True),
        ("yes", 0, False),
        ("Mono8", "Mono16", False),
        ("1.5", 1.5, True),
        (10**400, 1.5, False),
    ],
)
def test_values_are_compared_by_their_meaning(first, second, same):
    assert same_value(first, second) is same
    assert same_value(second, first) is same


def test_the_settings_under_all_entries_of_a_selector():
    channel = choice("Channel", "Red", "Red", "Blue")
    gain = replace(number("Gain", 1), selectors=("Channel",))
    grabber = ScriptedGrabber([channel, gain])
    assert [str(key) for key in instances_of(grabber, "Gain")] == ["Gain[Channel=Red]", "Gain[Channel=Blue]"]
    assert instances_of(grabber, "Offset") == []

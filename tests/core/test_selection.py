"""Settings as text, and reading and writing them as one step whoever else is at work."""

import threading

import pytest

from grabbergui import sources
from grabbergui.core.errors import FeatureError, UsageError
from grabbergui.core.selection import SettingKey

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
def test_what_is_no_key_is_refused(text):
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


def test_selectors_stand_where_they_stood(camera):
    camera.write_feature("BalanceRatioSelector", "Green")
    camera.write_setting(BLUE, 1.75)
    assert camera.read_setting(BLUE).value == 1.75
    with pytest.raises(FeatureError):
        camera.write_setting(BLUE, 1e9)
    assert camera.feature("BalanceRatioSelector").value == "Green"


def test_a_write_returns_all_that_it_changed(camera):
    camera.write_feature("ExposureAuto", "Continuous")
    result = camera.write_setting(SettingKey("ExposureTime"), 200_000.0)
    assert [(change.key.name, change.after) for change in result.written] == [
        ("ExposureAuto", "Off"),
        ("ExposureTime", 200_000.0),
    ]
    (rate,) = [change for change in result.consequences if change.key.name == "AcquisitionFrameRate"]
    assert rate.after == camera.feature("AcquisitionFrameRate").value < rate.before


def test_nobody_sees_or_moves_anothers_selection(camera):
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

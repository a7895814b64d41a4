"""Settings saved, compared, loaded and rolled back on the simulated camera."""

import threading
from contextlib import ExitStack

import pytest

from grabbergui import sources
from grabbergui.core.errors import DeviceLostError
from grabbergui.core.features import AccessMode
from grabbergui.core.grabber import Access
from grabbergui.core.settings import SettingKey
from grabbergui.models.language import set_translator
from grabbergui.models.settings import files
from grabbergui.models.settings.feature_set import FeatureSet, capture, compare
from grabbergui.models.settings.files import BAG_GUID, parse
from grabbergui.models.settings.loading import SettingOutcome, load_onto, roll_back
from lost_camera import away
from patience import PATIENCE, until

COLOUR = "sim:?width=64&height=48&pixel_format=BayerRG8"


@pytest.fixture
def camera():
    grabber = sources.create(COLOUR)
    grabber.open()
    yield grabber
    grabber.close()


def outcomes(report):
    return {str(setting.key): setting.outcome for setting in report.settings}


def red(value=None):
    return SettingKey("BalanceRatio", (("BalanceRatioSelector", "Red"),))


@pytest.mark.parametrize("name", ["settings.yaml", "settings.pfs"])
def test_saved_settings_are_loaded_onto_another_camera(camera, tmp_path, name):
    camera.write_feature("ExposureTime", 1234)
    camera.write_feature("BalanceRatioSelector", "Blue")
    camera.write_feature("BalanceRatio", 1.75)
    camera.write_feature("BalanceRatioSelector", "Red")
    camera.write_feature("BalanceRatio", 1.25)
    saved = capture(camera)
    files.save(saved, tmp_path / name)

    other = sources.create("sim:")
    other.open()
    try:
        read = files.load(tmp_path / name, other.selectors.of)
        assert compare(saved, read) == []
        report = load_onto(other, read)
        assert report.settled, [str(s) for s in report.settings]
        assert compare(capture(other), saved) == []
        assert other.feature("PixelFormat").value == "BayerRG8"
        assert load_onto(other, read).count(SettingOutcome.EQUAL) == len(read)
    finally:
        other.close()


def test_selectors_stand_afterwards_where_they_stood(camera):
    camera.write_feature("BalanceRatioSelector", "Blue")
    saved = capture(camera)
    assert red() in saved.settings
    assert camera.feature("BalanceRatioSelector").value == "Blue"
    load_onto(camera, FeatureSet({red(): 2.0}))
    assert camera.feature("BalanceRatioSelector").value == "Blue"
    camera.write_feature("BalanceRatioSelector", "Red")
    assert camera.feature("BalanceRatio").value == pytest.approx(2.0, abs=1e-3)


def test_only_differing_settings_are_written(camera, monkeypatch):
    saved = capture(camera)
    camera.write_feature("Gain", 6)
    written = []
    really = camera.write_setting
    monkeypatch.setattr(camera, "write_setting", lambda k, v: (written.append(k.name), really(k, v))[1])
    report = load_onto(camera, saved)
    assert written == ["Gain"]
    assert outcomes(report)["Gain"] is SettingOutcome.WRITTEN
    assert report.count(SettingOutcome.EQUAL) == len(saved) - 1


def test_a_wrong_order_is_mended_by_further_passes(camera):
    camera.write_feature("OffsetX", 0)
    camera.write_feature("Width", camera.feature("Width").maximum)
    assert camera.feature("OffsetX").maximum == 0
    report = load_onto(camera, FeatureSet({SettingKey("OffsetX"): 200, SettingKey("Width"): 64}))
    assert report.settled, [str(s) for s in report.settings]
    assert camera.feature("OffsetX").value == 200


def test_each_setting_has_an_outcome(camera):
    settings = {
        SettingKey("ExposureTime"): 2000.0,
        SettingKey("Gain"): 1e9,
        SettingKey("Flavour"): "vanilla",
        SettingKey("DeviceModelName"): "other",
        SettingKey("TriggerSoftware"): 1,
        SettingKey("TriggerMode", (("TriggerSelector", "Nowhere"),)): "On",
        SettingKey("PixelFormat"): "BayerRG8",
    }
    report = load_onto(camera, FeatureSet(settings))
    assert outcomes(report) == {
        "ExposureTime": SettingOutcome.WRITTEN,
        "Gain": SettingOutcome.REFUSED,
        "Flavour": SettingOutcome.UNKNOWN,
        "DeviceModelName": SettingOutcome.REFUSED,
        "TriggerSoftware": SettingOutcome.REFUSED,
        "TriggerMode[TriggerSelector=Nowhere]": SettingOutcome.REFUSED,
        "PixelFormat": SettingOutcome.EQUAL,
    }
    reasons = {setting.key.name: setting.reason for setting in report.settings}
    assert "out of range" in reasons["Gain"]
    assert "read-only" in reasons["DeviceModelName"]
    assert not report.settled
    assert report.summary() == "1 written, 1 equal, 4 refused, 1 unknown"


def test_rolling_back_restores_all_settings(camera):
    before = capture(camera)
    report = load_onto(
        camera, FeatureSet({SettingKey("ExposureAuto"): "Continuous", SettingKey("Width"): 128, red(): 3.0})
    )
    assert compare(before, capture(camera))
    roll_back(camera, report)
    left = [d for d in compare(before, capture(camera)) if d.key.name != "ExposureTime"]
    assert left == []


def test_progress_grows_up_to_the_whole(camera):
    seen = []
    wanted = FeatureSet({SettingKey("Gain"): 3.0, SettingKey("Width"): 128, red(): 2.0})
    assert load_onto(camera, wanted, progress=lambda done, of: seen.append(done / of)).settled
    assert seen == sorted(seen)
    assert seen[0] < 0.1 and seen[-1] == 1.0
    assert len(seen) > 10


@pytest.mark.parametrize("share", [0.0, 0.3, 0.6, 0.71])
def test_loading_can_be_cancelled_at_any_moment_and_rolled_back(camera, share):
    before = capture(camera)
    cancelled = threading.Event()
    wanted = FeatureSet({SettingKey("Gain"): 3.0, SettingKey("Width"): 128, red(): 2.0})

    def cancel(done, of):
        if done / of >= share:
            cancelled.set()

    report = load_onto(camera, wanted, progress=cancel, cancelled=cancelled)
    assert report.count(SettingOutcome.CANCELLED) == (2 if share > 0.7 else 3)
    assert report.count(SettingOutcome.WRITTEN) == (1 if share > 0.7 else 0)
    if report.count(SettingOutcome.WRITTEN):
        assert roll_back(camera, report).settled
    assert compare(before, capture(camera)) == []


def test_an_automatic_mode_that_the_set_turns_on_stays_on(camera):
    settings = {SettingKey("ExposureAuto"): "Continuous", SettingKey("ExposureTime"): 777.0}
    report = load_onto(camera, FeatureSet(settings))
    assert outcomes(report)["ExposureTime"] is SettingOutcome.LEFT_ALONE
    assert camera.feature("ExposureAuto").value == "Continuous"


def test_a_switch_that_the_set_turns_off_stays_off(camera):
    settings = {SettingKey("AcquisitionFrameRate"): 7.0, SettingKey("AcquisitionFrameRateEnable"): False}
    load_onto(camera, FeatureSet(settings))
    assert camera.feature("AcquisitionFrameRateEnable").value is False


def test_a_dry_run_writes_nothing(camera):
    before = capture(camera)
    report = load_onto(camera, FeatureSet({SettingKey("Gain"): 3.0}), dry_run=True)
    assert outcomes(report) == {"Gain": SettingOutcome.WOULD_WRITE}
    assert compare(before, capture(camera)) == []


def test_a_running_stream_runs_on_with_the_new_size(camera):
    queue = camera.open_queue()
    camera.start()
    queue.get(PATIENCE)
    report = load_onto(camera, FeatureSet({SettingKey("Width"): 128, SettingKey("BinningHorizontal"): 2}))
    assert report.settled, [str(s) for s in report.settings]
    assert camera.streaming
    queue.clear()
    assert queue.get(PATIENCE).width == 128


def test_with_read_only_access_only_selected_instances_are_captured():
    grabber = sources.create(COLOUR)
    grabber.open(Access.MONITOR)
    try:
        if grabber.access is not Access.MONITOR:
            pytest.skip("the simulated camera gives control to whoever asks for less")
        saved = capture(grabber)
        assert SettingKey("Width") in saved.settings
        assert len([key for key in saved.settings if key.name == "BalanceRatio"]) == 1
        assert any("BalanceRatio" in text for text in saved.left_out)
        assert grabber.feature("Width").access is AccessMode.READ_ONLY
    finally:
        grabber.close()


def test_a_file_alone_distinguishes_instances(camera):
    saved = capture(camera)
    text = files.to_persistence(saved)
    other = files.to_persistence(FeatureSet({**saved.settings, red(): 2.5}))
    differences = compare(files.parse(text, "a"), files.parse(other, "b"))
    assert [str(d.key) for d in differences] == [str(red())]
    assert str(differences[0]).endswith("→ 2.5")


def test_a_frame_rate_is_set_after_an_exposure_that_an_automatic_mode_left_too_long(camera):
    """The mode holds the exposure while the camera is stopped, and it limits the frame rate."""
    camera.write_feature("ExposureTime", 500_000.0)
    camera.write_feature("ExposureAuto", "Continuous")
    settings = {
        SettingKey("AcquisitionFrameRate"): 12.5,
        SettingKey("ExposureTime"): 10_000.0,
        SettingKey("ExposureAuto"): "Continuous",
    }
    report = load_onto(camera, FeatureSet(settings))
    assert report.settled, report.lines()
    assert camera.feature("AcquisitionFrameRate").value == 12.5
    assert camera.feature("ExposureAuto").value == "Continuous"


@pytest.mark.parametrize(
    "text", [f"# {BAG_GUID}\nGain\t3\nstray line\nGamma\t2\n", "features:\n  Gain: 3\n  ?\n  Gamma: 2\n"]
)
def test_one_stray_line_costs_that_line(camera, text):
    features = parse(text, "some.txt", camera.selectors.of)
    assert {str(key) for key in features.settings} == {"Gain", "Gamma"}
    (lost,) = features.lost_lines
    assert lost.startswith("some.txt, line 3:")
    report = load_onto(camera, features)
    assert camera.feature("Gamma").value == 2 and not report.settled
    assert report.lines()[0] == lost


def test_comparing_promises_only_what_loading_accepts(camera):
    settings = {
        SettingKey("Gain"): 1e9,
        SettingKey("PixelFormat"): "Mono9",
        SettingKey("Gamma"): "bright",
        SettingKey("BlackLevel"): 5.0,
    }
    promised = outcomes(load_onto(camera, FeatureSet(settings), dry_run=True))
    assert promised["BlackLevel"] is SettingOutcome.WOULD_WRITE
    assert promised["Gain"] is SettingOutcome.DEPENDS
    assert promised["PixelFormat"] is promised["Gamma"] is SettingOutcome.REFUSED
    kept = outcomes(load_onto(camera, FeatureSet(settings)))
    assert {name for name, outcome in kept.items() if outcome is SettingOutcome.WRITTEN} == {"BlackLevel"}


def test_an_interrupted_load_reports_which_settings_were_written(camera, monkeypatch):
    really = camera.write_setting

    def write(key, value):
        if key.name == "Gamma":
            raise DeviceLostError("the cable is out")
        return really(key, value)

    monkeypatch.setattr(camera, "write_setting", write)
    settings = {SettingKey("Gain"): 3.0, SettingKey("Gamma"): 2.0, SettingKey("BlackLevel"): 5.0}
    report = load_onto(camera, FeatureSet(settings))
    found = outcomes(report)
    assert found == {
        "Gain": SettingOutcome.WRITTEN,
        "Gamma": SettingOutcome.NOT_WRITTEN,
        "BlackLevel": SettingOutcome.NOT_WRITTEN,
    }
    assert report.problem == "interrupted: the cable is out" and report.interrupted and not report.settled
    reasons = {setting.key.name: setting.reason for setting in report.settings}
    assert "during this write" in reasons["Gamma"] and reasons["BlackLevel"] == "the cable is out"


@pytest.mark.parametrize(("share", "written"), [(0.1, 0), (0.6, 0), (0.7, 0), (0.8, 1)])
def test_a_load_interrupted_by_a_loss_lists_all_settings_and_the_stream_continues(camera, share, written):
    """At whatever moment: while the camera is read, compared, or written to."""
    wanted = {"Gain": 3.0, "Gamma": 2.0, "BlackLevel": 5.0, "Width": camera.feature("Width").value}
    features = FeatureSet({SettingKey(name): value for name, value in wanted.items()})
    camera.start()
    with ExitStack() as loss:

        def progress(done, of):
            if done / of >= share and not camera.lost:
                loss.enter_context(away(camera, "the cable is out"))

        report = load_onto(camera, features, progress=progress)
        assert [setting.key.name for setting in report.settings] == list(wanted)
        assert report.interrupted and report.written == written
        assert report.problem.startswith("interrupted: ")
        left = [each for each in report.settings if each.outcome is SettingOutcome.NOT_WRITTEN]
        assert len(left) >= 2 and all(each.reason for each in left)
        assert len(report.lines()) == (len(left) + written + 2 if written else 2)
    until(lambda: not camera.lost, "its return")
    assert camera.streaming
    assert camera.feature("Gain").value == (3.0 if written else 0.0)


def test_features_locked_only_by_the_stream_are_saved_too(camera):
    before = capture(camera)
    camera.start()
    assert {SettingKey("Width"), SettingKey("PixelFormat")} <= set(before.settings)
    streaming = capture(camera)
    assert before.settings.items() <= streaming.settings.items()


def test_format_and_region_are_rolled_back_while_it_streams(camera):
    before = capture(camera)
    camera.start()
    report = load_onto(camera, FeatureSet({SettingKey("PixelFormat"): "Mono12", SettingKey("Width"): 128}))
    assert report.settled, report.lines()
    assert roll_back(camera, report).settled
    assert camera.streaming
    camera.stop()
    assert compare(before, capture(camera)) == []


def test_format_and_region_are_set_while_it_streams(camera):
    wanted = {"PixelFormat": "BayerRG12p", "Width": 128, "Height": 64, "OffsetX": 32, "OffsetY": 16}
    camera.start()
    report = load_onto(camera, FeatureSet({SettingKey(name): value for name, value in wanted.items()}))
    assert report.settled, report.lines()
    assert {name: camera.feature(name).value for name in wanted} == wanted
    assert camera.streaming
    assert roll_back(camera, report).settled


def test_the_reason_for_an_open_outcome_is_in_the_users_language(camera):
    locked = FeatureSet({SettingKey("DeviceTemperature"): 5.0})
    set_translator(lambda context, text: f"<{text}>")
    try:
        (report,) = load_onto(camera, locked, dry_run=True).settings
    finally:
        set_translator(None)
    assert report.outcome is SettingOutcome.DEPENDS
    assert report.reason == "<is read-only; streaming or another feature may lock it>"

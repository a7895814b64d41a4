"""The command line as a person uses it, on the simulated camera."""

import errno
import json
import sys
import threading

import cv2
import numpy as np
import pytest

from fakes import ScriptedGrabber
from grabbergui import sources
from grabbergui.cli import main
from grabbergui.core.errors import AccessDeniedError
from grabbergui.core.grabber import Access, ConnectionState
from grabbergui.recording.opening import playable_frames
from grabbergui.recording.stack_writer import NpyWriter, TiffWriter

SMALL = "sim:?width=64&height=48&fps=100"


def run(capsys, *arguments):
    """Exit code, stdout, stderr."""
    try:
        code = main(arguments)
    except SystemExit as error:  # argparse's own
        code = error.code
    printed = capsys.readouterr()
    return code, printed.out, printed.err


def test_list_waits_at_its_default_for_what_ros_announces_every_three_seconds(capsys, monkeypatch):
    asked = {}

    def answer(kind, timeout):
        asked[kind] = timeout
        return []

    monkeypatch.setattr(sources, "_discover", answer)
    run(capsys, "list")
    assert asked["gige"] == 2.0 and 3.0 < asked["ros2"] < 4.0
    run(capsys, "list", "--timeout", "2")
    assert set(asked.values()) == {2.0}, "what the user says holds for every kind"


def test_list_says_on_a_terminal_that_it_searches(capsys, monkeypatch):
    seen = []
    monkeypatch.setattr(sources, "discover", lambda *_: seen.append(capsys.readouterr().err) or [])
    run(capsys, "list")
    assert seen.pop() == ""
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    *_, err = run(capsys, "list")
    assert "searching" in seen.pop() and err == "\r\033[K"


def test_features_as_json_have_values_and_ranges(capsys):
    code, out, _ = run(capsys, "features", SMALL, "--json")

    assert code == 0
    features = {feature["name"]: feature for feature in json.loads(out)}
    width = features["Width"]
    assert (width["value"], width["kind"]) == (64, "integer") and width["maximum"] == 4096
    assert features["ExposureTime"]["unit"] == "us" and features["ExposureTime"]["auto"] == "ExposureAuto"
    assert "Mono8" in features["PixelFormat"]["entries"]


def test_human_readable_features_are_indented_below_their_category(capsys):
    code, out, _ = run(capsys, "features", SMALL)

    assert code == 0
    assert "Acquisition Control\n" in out
    assert "\n  Width = 64 px (16 … 4096 px, step 8)\n" in out


def test_get_prints_a_line_each(capsys):
    assert run(capsys, "get", SMALL, "Width", "PixelFormat") == (
        0,
        "Width = 64 px\nPixelFormat = Mono8\n",
        "",
    )


def test_a_value_is_printed_with_its_selectors(capsys):
    red, blue = (f"BalanceRatio[BalanceRatioSelector={colour}]" for colour in ("Red", "Blue"))
    settings = ("PixelFormat=RGB8", f"{blue}=1.5", "BalanceRatioSelector=Red", "BalanceRatio=2")
    code, out, _ = run(capsys, "set", SMALL, *settings)
    assert (code, out.splitlines()[1:]) == (0, [f"{blue} = 1.5", "BalanceRatioSelector = Red", f"{red} = 2"])

    off, test = "EventNotification", "EventNotification[EventSelector=Test]"
    code, out, _ = run(capsys, "get", SMALL, off, test)
    assert (code, out.splitlines()) == (0, [f"{off}[EventSelector=FrameStart] = Off", f"{test} = Off"])


def test_set_works_in_order_and_prints_what_the_camera_reports(capsys):
    code, out, _ = run(capsys, "set", SMALL, "ExposureAuto=Continuous", "ExposureTime=2e3", "ReverseX=on")

    assert (code, out) == (0, "ExposureAuto = Continuous\nExposureTime = 2000 us\nReverseX = true\n")


def test_run_executes_a_command(capsys):
    assert run(capsys, "run", SMALL, "TimestampLatch") == (0, "", "")


@pytest.mark.parametrize(
    "arguments",
    [
        ["get"],
        ["get", "sim:"],
        ["set", "sim:", "Width"],
        ["grab", "sim:", "-n", "0"],
        ["features", "nowhere"],
        ["features", "floppy:1"],
        ["gui", "nowhere"],
        ["gui", "--duration", "-1"],
        ["gui", "--duration", "1e10"],
        ["list", "--timeout", "1e10"],
        ["list", "--timeout", "0s"],
        ["persistent-ip", "gige:", "192.168.0.999"],
        ["force-ip", "00:30:53:12:34:56", "camera"],
    ],
    ids=" ".join,
)
def test_wrong_usage_is_exit_code_2(capsys, arguments):
    code, out, err = run(capsys, *arguments)

    assert (code, out) == (2, "")
    assert err and "Traceback" not in err


@pytest.mark.parametrize(
    "arguments",
    [
        ["load", "sim:", "MISSING.yaml"],
        ["diff", "sim:", "MISSING.yaml"],
        ["diff", "MISSING.yaml", "MISSING.yaml"],
        ["save", "sim:", "MISSING/a.yaml"],
        ["record", "sim:", "--out", "MISSING/a.mcap"],
        ["grab", "file:MISSING.mcap"],
        ["get", "gentl:MISSING.cti", "Width"],
        ["serve", "sim:", "--from", "MISSING.ini"],
        ["gui", "--offscreen", "--script", "MISSING.py"],
    ],
    ids=" ".join,
)
def test_a_missing_file_is_named_and_exit_code_2(capsys, monkeypatch, tmp_path, arguments):
    monkeypatch.chdir(tmp_path)

    code, out, err = run(capsys, *arguments)

    assert (code, out) == (2, "")
    assert "there is no" in err and "MISSING" in err and err.count("\n") == 1
    assert not any(tmp_path.iterdir())


@pytest.mark.parametrize(
    "arguments",
    [
        ["events", SMALL, "--start", "ExposureEnd", "-n", "1", "--json"],
        ["events", "--start", "-n", "1", SMALL, "--json", "ExposureEnd"],
        ["events", SMALL, "ExposureEnd", "--start", "-n", "1", "--json"],
    ],
    ids=" ".join,
)
def test_options_may_stand_anywhere(capsys, arguments):
    code, out, _ = run(capsys, *arguments)

    assert code == 0
    assert json.loads(out)["event"] == "ExposureEnd"


def test_times_may_have_a_unit(capsys):
    code, out, _ = run(capsys, "grab", SMALL, "--timeout", "5000ms", "--json")

    assert (code, json.loads(out)["frames"]) == (0, 1)


def test_numbers_may_have_a_unit_as_in_the_window(capsys):
    code, out, _ = run(
        capsys, "set", "sim:", "ExposureTime=20ms", "AcquisitionFrameRate=0.01 kHz", "Width=640px"
    )

    assert code == 0
    assert out.splitlines() == ["ExposureTime = 20000 us", "AcquisitionFrameRate = 10 Hz", "Width = 640 px"]


def test_grab_counts(capsys):
    code, out, _ = run(capsys, "grab", SMALL, "-n", "5", "--json")

    assert code == 0
    summary = json.loads(out)
    assert summary["frames"] == 5 and summary["bytes"] == 5 * 64 * 48
    assert (summary["incomplete"], summary["lost"]) == (0, 0)
    assert (summary["width"], summary["height"], summary["pixel_format"]) == (64, 48, "Mono8")
    assert 5 < summary["fps"] < 200 and summary["seconds"] > 0


def test_grab_sets_first_and_saves_every_frame(capsys, tmp_path):
    folder = tmp_path / "new" / "frames"
    code, out, _ = run(capsys, "grab", SMALL, "-n", "3", "--set", "PixelFormat=Mono12p", "--out", str(folder))

    assert code == 0 and out.startswith("3 frames of 64×48 Mono12p")
    files = sorted(folder.iterdir())
    assert len(files) == 3
    assert cv2.imread(str(files[0]), cv2.IMREAD_UNCHANGED).shape == (48, 64)


def test_a_trigger_that_never_comes_ends_in_a_hint(capsys):
    code, _, err = run(capsys, "grab", SMALL, "--set", "TriggerMode=On", "--keep-trigger", "--timeout", "0.3")

    assert code == 1
    assert "no frame within 0.3 s after 0 frames" in err and "trigger" in err


class HeldGrabber(ScriptedGrabber):
    """Another application has control; reading is granted."""

    def open(self, access=Access.CONTROL):
        if access is Access.CONTROL:
            raise AccessDeniedError("another application controls it; close it there")


@pytest.mark.parametrize(
    ("arguments", "end"),
    [
        (["grab", "sim:"], "close it there, or look on with --monitor\n"),
        (["record", "sim:", "--out", "new.mcap"], "close it there, or look on with --monitor\n"),
        (["set", "sim:", "Gain=1"], "close it there\n"),
    ],
)
def test_a_camera_in_use_names_the_option_that_the_command_has(monkeypatch, capsys, arguments, end):
    monkeypatch.setattr(sources, "create", lambda uri: HeldGrabber())

    code, _, err = run(capsys, *arguments)

    assert code == 1 and err.endswith(end)


def test_looking_on_takes_no_control(capsys):
    code, _, err = run(capsys, "grab", SMALL, "--monitor", "--timeout", "0.3")

    assert code == 1 and "see whether the application that controls it streams" in err


def test_a_camera_that_is_lost_is_no_trigger_to_look_for(monkeypatch, capsys):
    camera = sources.create(SMALL)
    monkeypatch.setattr(sources, "create", lambda uri: camera)
    monkeypatch.setattr(
        camera, "start", lambda **options: camera.connection_changed.emit(ConnectionState.LOST, "unplugged")
    )

    code, _, err = run(capsys, "grab", SMALL, "--timeout", "0.3", "--lost-timeout", "0.4")

    assert code == 1
    assert "was lost and did not come back within 0.4 s: unplugged" in err
    assert "trigger" not in err


@pytest.mark.parametrize("command", [["grab"], ["record", "-n", "1", "--out", "images"]])
def test_a_source_that_is_away_is_waited_for_longer_than_for_a_frame(command, monkeypatch, capsys, tmp_path):
    monkeypatch.chdir(tmp_path)
    camera = sources.create(SMALL)
    monkeypatch.setattr(sources, "create", lambda uri: camera)
    start = camera.start

    def be_away(**options):
        camera.connection_changed.emit(ConnectionState.LOST, "unplugged")
        threading.Timer(1.5, come_back).start()

    def come_back():
        start()
        camera.connection_changed.emit(ConnectionState.OPEN, "plugged in")

    monkeypatch.setattr(camera, "start", be_away)

    code, _, err = run(capsys, command[0], SMALL, "--timeout", "1", *command[1:])

    assert (code, err) == (0, "")


def test_grab_saves_every_component_and_the_point_cloud(capsys, tmp_path):
    enable = ["--set", "ComponentSelector=Range", "--set", "ComponentEnable=on"]
    assert run(capsys, "grab", SMALL, *enable, "--out", str(tmp_path), "--ply")[0] == 0
    assert sorted(path.suffix for path in tmp_path.iterdir()) == [".ply", ".png", ".tiff"]
    code, _, problem = run(capsys, "grab", SMALL, "--ply")
    assert code != 0 and "--out" in problem


def test_an_assignment_of_two_words_is_answered_with_one(capsys):
    assert main(["set", "sim:", "ExposureTime", "20ms"]) == 2
    assert "'ExposureTime' is not NAME=VALUE; write it in one word, as in ExposureTime=20ms" in (
        capsys.readouterr().err
    )


@pytest.fixture
def recording(tmp_path):
    """The source of a recording of four frames that ends."""
    np.save(tmp_path / "run.npy", np.zeros((4, 8, 16), np.uint8))
    return f"file:{tmp_path / 'run.npy'}?loop=0&speed=20"


def test_a_recording_is_converted_to_its_end(capsys, tmp_path, recording):
    code, out, err = run(capsys, "record", recording, "--out", str(tmp_path / "run.mcap"))
    assert (code, err) == (0, "") and "run.mcap: 4 frames in" in out


@pytest.mark.parametrize("name", ["stack.tiff", "array.npy"])
def test_a_recording_of_fewer_frames_than_wanted_is_saved_to_its_end(capsys, tmp_path, recording, name):
    code, _, err = run(capsys, "grab", recording, "-n", "5", "--out", str(tmp_path / name))
    assert (code, err) == (1, "grabbergui: run.npy ended after 4 frames\n")
    assert playable_frames(tmp_path / name) == 4


@pytest.mark.parametrize("name", ["stack.tiff", "array.npy"])
def test_without_a_frame_the_name_is_free_again(capsys, tmp_path, name):
    waiting = (SMALL, "--keep-trigger", "--set", "TriggerMode=On", "--timeout", "0.1")
    code, _, err = run(capsys, "grab", *waiting, "--out", str(tmp_path / name))
    assert code == 1 and "trigger" in err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["stack.tiff", "array.npy"])
def test_a_disk_that_is_full_is_reported_with_the_file(capsys, tmp_path, monkeypatch, name):
    def write(writer, frame):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(NpyWriter if name.endswith("npy") else TiffWriter, "write", write)
    code, _, err = run(capsys, "grab", SMALL, "--out", str(tmp_path / name))
    assert code == 1
    assert err == f"grabbergui: {tmp_path / name} could not be written: No space left on device\n"

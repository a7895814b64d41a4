"""`save`, `load`, `diff` and `record` as one types them."""

import argparse
import json
from contextlib import ExitStack
from itertools import count

import pytest

from grabbergui.cli import EXIT_FAILURE, CommandParser, features, grab, main, record
from grabbergui.cli.arguments import Outage
from grabbergui.core.errors import GrabberError, MissingFileError, TransportError, UsageError
from grabbergui.driver.device_grabber import DeviceGrabber
from grabbergui.models.settings.loading import LoadReport, SettingOutcome, SettingReport
from grabbergui.recording.opening import open_recording
from lost_camera import away

SMALL = "sim:?width=64&height=48&fps=100"


def run(*arguments):
    parser = argparse.ArgumentParser()
    commands = parser.add_subparsers(required=True, parser_class=CommandParser)
    features.add_commands(commands)
    grab.add_commands(commands)
    record.add_commands(commands)
    options = parser.parse_args([str(argument) for argument in arguments])
    return options.run(options)


@pytest.mark.parametrize("name", ["a.yaml", "a.pfs"])
def test_settings_are_saved_compared_and_loaded(tmp_path, capsys, name):
    path = tmp_path / name
    assert run("save", SMALL + "&exposure=2000", path) == 0
    assert "saved" in capsys.readouterr().out
    assert run("diff", SMALL + "&exposure=2000", path) == 0
    assert run("diff", SMALL + "&exposure=3000", path) == 1
    assert capsys.readouterr().out == "ExposureTime: 3000 → 2000\n"
    assert run("load", SMALL + "&exposure=3000", path, "--dry-run") == 0
    assert "would write ExposureTime: 3000 → 2000" in capsys.readouterr().out
    assert run("load", SMALL + "&exposure=3000", path) == 0
    assert "written     ExposureTime: 3000 → 2000" in capsys.readouterr().out


def test_files_of_both_kinds_compare(tmp_path, capsys):
    colour = SMALL + "&pixel_format=BayerRG8"
    run("save", colour, tmp_path / "a.yaml")
    run("save", colour, tmp_path / "b.pfs")
    capsys.readouterr()
    assert run("diff", tmp_path / "a.yaml", tmp_path / "b.pfs") == 0
    assert run("diff", tmp_path / "b.pfs", tmp_path / "a.yaml") == 0
    assert capsys.readouterr().out == ""


def test_a_set_that_does_not_fit_fails_and_can_be_rolled_back(tmp_path, capsys):
    (tmp_path / "a.yaml").write_text("features:\n  Gain: 3\n  Flavour: vanilla\n")
    with pytest.raises(GrabberError, match="1 of 2"):
        run("load", SMALL, tmp_path / "a.yaml", "--all-or-nothing")
    reported = capsys.readouterr().out
    assert "unknown     Flavour" in reported
    assert "rolled back: 1 written" in reported


def test_a_loss_while_settings_are_loaded_leaves_a_list_of_what_was_written(tmp_path, capsys, monkeypatch):
    (tmp_path / "a.yaml").write_text("features:\n  Gamma: 2\n  BlackLevel: 5\n")
    write = DeviceGrabber.write_setting
    with ExitStack() as loss:

        def written_last(camera, key, value):
            result = write(camera, key, value)
            loss.enter_context(away(camera, "the cable is out"))
            return result

        monkeypatch.setattr(DeviceGrabber, "write_setting", written_last)
        with pytest.raises(GrabberError, match="1 of 2 settings are not as"):
            run("load", SMALL, tmp_path / "a.yaml")
    reported = capsys.readouterr().out.splitlines()
    assert reported[0] == "written     Gamma: 1 → 2" and reported[1].startswith(
        "not written BlackLevel: 2 → 5 ("
    )
    assert reported[2].startswith("interrupted: ")


def test_a_loss_before_the_written_values_were_read_back_is_the_failure(tmp_path, monkeypatch):
    (tmp_path / "a.yaml").write_text("features:\n  Gamma: 2\n")

    def load_onto(grabber, wanted, **options):
        settings = tuple(SettingReport(key, 2, SettingOutcome.WRITTEN, 1, 2) for key in wanted.settings)
        return LoadReport(settings, wanted, "interrupted: the cable is out", interrupted=True)

    monkeypatch.setattr(features, "load_onto", load_onto)
    with pytest.raises(GrabberError, match=r"^interrupted: the cable is out$"):
        run("load", SMALL, tmp_path / "a.yaml")


@pytest.mark.parametrize(
    ("name", "options"),
    [("m.mcap", []), ("m.mp4", []), ("m.mp4", ["--lossless"]), ("m", []), ("m", ["--tiff"])],
)
def test_frames_are_recorded(tmp_path, capsys, name, options):
    assert run("record", SMALL, "--out", tmp_path / name, "-n", 5, *options) == 0
    assert "5 frames" in capsys.readouterr().out
    recording = open_recording(tmp_path / name)
    assert len(recording) == 5
    recording.close()


def test_a_recording_of_a_source_that_stays_lost_says_what_it_has(tmp_path, capsys, monkeypatch):
    looks = count()

    def check(outage):
        if next(looks) % 10 == 9:
            raise TransportError("the camera was lost")

    monkeypatch.setattr(Outage, "check", check)
    assert main(["record", SMALL, "--out", str(tmp_path / "a.mcap")]) == EXIT_FAILURE
    printed = capsys.readouterr()
    assert "frames in" in printed.out and printed.err == "grabbergui: the camera was lost\n"
    assert main(["record", SMALL, "--out", str(tmp_path / "b.mcap"), "--json"]) == EXIT_FAILURE
    reported = json.loads(capsys.readouterr().out)
    assert reported["frames"] > 0 and reported["bytes"] > 0 and reported["path"] == str(tmp_path / "b.mcap")
    assert reported["error"] == {"type": "TransportError", "message": "the camera was lost"}


def test_settings_that_do_not_fit_are_listed_beside_the_error(tmp_path, capsys):
    (tmp_path / "a.yaml").write_text("features:\n  Gain: 3\n  Flavour: vanilla\n")
    assert main(["load", SMALL, str(tmp_path / "a.yaml"), "--json"]) == EXIT_FAILURE
    reported = json.loads(capsys.readouterr().out)
    assert [each["outcome"] for each in reported["settings"]] == ["written", "unknown"]
    assert reported["error"]["type"] == "GrabberError"
    assert reported["error"]["message"].startswith("1 of 2 settings are not as")


def test_what_makes_no_sense_is_refused(tmp_path):
    numbers = (["-n", "0"], ["-t", "0"], ["-t", "nan"], ["--size", "inf"], ["--timeout", "-1"])
    for wrong in (*numbers, ["--tiff"], ["--lossless"]):
        with pytest.raises(UsageError):
            run("record", SMALL, "--out", tmp_path / "m.mcap", *wrong)
    assert not (tmp_path / "m.mcap").exists()


def test_a_missing_folder_is_named_alike_by_all_that_write_before_they_begin(tmp_path):
    missing, nothing = tmp_path / "nowhere", f"file:{tmp_path / 'nothing'}"
    for command in (
        ["save", nothing, missing / "a.yaml"],
        ["record", nothing, "--out", missing / "m.mcap", "-n", 1],
    ):
        with pytest.raises(MissingFileError, match=f"there is no folder {missing} for"):
            run(*command)
    assert not missing.exists()

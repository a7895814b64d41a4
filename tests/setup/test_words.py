"""The words that completion proposes at each place of a command line."""

import json
import subprocess
import sys

import pytest

from grabbergui.setup.completion import (
    TABLE,
    Completer,
    Seen,
    for_shell,
    main,
    simulated_features,
    typed_in_bash,
)
from patience import PROGRAM

FOUND = ["gige:192.168.0.10", "u3v:SN1"]


@pytest.fixture
def completer():
    names = {"gige:GV01": ["GainRaw", "ExposureTimeAbs"]}
    table = json.loads(TABLE.read_text("utf-8"))
    return Completer(table, lambda: FOUND, lambda uri: names.get(uri, ["ExposureTime", "Gain"]))


@pytest.mark.parametrize(
    ("typed", "proposed"),
    [
        ("rec", ["record"]),
        ("--log-l", ["--log-level"]),
        ("--log-level d", ["debug"]),
        ("--log-level debug rec", ["record"]),
        ("gige:", ["gige:", "gige:192.168.0.10"]),
        ("get u", ["u3v:", "u3v:SN1"]),
        ("get sim: Exp", ["ExposureTime"]),
        ("get gige:GV01 Exp", ["ExposureTimeAbs"]),
        ("get gige:GV01 GainRaw Exp", ["ExposureTimeAbs"]),
        ("set sim: Ga", ["Gain="]),
        ("run sim: Gain", ["Gain"]),
        ("gui --theme l", ["light"]),
        ("gui --theme=l", ["--theme=light"]),
        ("sim: --scr", ["--screenshot", "--script"]),
        ("setup de", ["desktop"]),
        ("setup desktop --shell z", ["zsh"]),
        ("save sim: camera.yaml ", []),
        ("list x", []),
    ],
)
def test_a_word_is_completed(completer, typed, proposed):
    assert sorted(completer.answer(typed.split(" ")).words) == sorted(proposed)


def test_every_command_is_proposed_with_its_meaning(completer):
    words = completer.answer([""]).words
    assert {"list", "serve", "setup"} <= words.keys() and all(words.values())


@pytest.mark.parametrize(
    ("typed", "directive"),
    [
        ("save sim: ", "files"),
        ("record sim: --out ", "files"),
        ("diff cam", "files"),
        ("set sim: Gai", "nospace"),
        ("yar", "words"),
        ("get yarp", "nospace"),
        ("get sim", "words"),
    ],
)
def test_the_shell_gets_a_directive(completer, typed, directive):
    assert completer.answer(typed.split(" ")).directive == directive


def test_paths_behind_file_are_completed(completer, tmp_path, monkeypatch):
    (tmp_path / "scene.mcap").touch()
    (tmp_path / "scenes").mkdir()
    monkeypatch.chdir(tmp_path)
    assert set(completer.answer(["get", "file:sc"]).words) == {"file:scene.mcap", "file:scenes/"}
    deep = completer.answer([f"file:{tmp_path}/scene."])
    assert set(deep.words) == {f"file:{tmp_path}/scene.mcap"}
    assert not completer.answer(["file:/no/such/folder/"]).words


def test_bash_gets_what_follows_its_word_breaks(completer):
    found = completer.answer(["gige:"])
    assert for_shell("bash", found, "gige:", " \t\n\"'><=;|&(:").splitlines() == ["words", "", "192.168.0.10"]
    assert for_shell("bash", found, "gige:", " ").splitlines() == ["words", "gige:", "gige:192.168.0.10"]


def test_zsh_gets_colons_escaped(completer):
    assert "gige\\:192.168.0.10:found" in for_shell("zsh", completer.answer(["gige:"]), "").splitlines()


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("grabbergui ", [""]),
        ("grabbergui get si", ["get", "si"]),
        ("grabbergui get 'sim:", ["get", "sim:"]),
        ("grabbergui get sim: ", ["get", "sim:", ""]),
        ('grabbergui get "', ["get", ""]),
    ],
)
def test_an_unfinished_line_of_bash_is_split(line, words):
    assert typed_in_bash(line) == words


def test_an_unknown_shell_is_refused(capsys):
    assert main(["tcsh", "grabbergui"]) == 2
    assert "bash, zsh, fish" in capsys.readouterr().err


def test_commands_are_completed_without_the_imports_of_the_commands():
    code = (
        "import sys; sys.argv = ['grabbergui', '--complete', 'fish', 'grabbergui', 'rec']\n"
        "from grabbergui.__main__ import main; main()\n"
        "print([name for name in ('numpy', 'grabbergui.cli') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=PROGRAM)
    assert done.stdout.splitlines()[:2] == ["words", "record\trecord frames; play them back with file:PATH"]
    assert done.stdout.splitlines()[-1] == "[]"


# -- what was seen ---------------------------------------------------------------------------------
def test_sources_are_kept_for_a_while(tmp_path):
    now = [1000.0]
    seen = Seen(tmp_path / "below" / "seen.json", lambda: now[0])
    assert seen.sources(60) is None
    seen.keep_sources(FOUND)
    assert seen.sources(60) == FOUND
    now[0] += 61
    assert seen.sources(60) is None


def test_features_are_those_of_the_source_or_of_the_simulated_camera(tmp_path):
    seen = Seen(tmp_path / "seen.json")
    seen.keep_features("gige:GV01", ["GainRaw"])
    seen.keep_sources(FOUND)
    assert seen.features("gige:GV01") == ["GainRaw"]
    assert seen.features("gige:GV02") == simulated_features()
    assert {"ExposureTime", "Gain", "TriggerSoftware"} <= set(simulated_features())


def test_no_more_than_twenty_cameras_are_kept(tmp_path):
    seen = Seen(tmp_path / "seen.json")
    for number in range(25):
        seen.keep_features(f"gige:{number}", [f"Feature{number}"])
    kept = json.loads(seen.file.read_text())["features"]
    assert list(kept) == [f"gige:{number}" for number in range(5, 25)]


@pytest.mark.parametrize(
    "content", ["", "[]", "{", '{"sources": 3, "features": []}', '{"features": {"a": 1}}']
)
def test_a_damaged_file_is_as_none(tmp_path, content):
    seen = Seen(tmp_path / "seen.json")
    seen.file.write_text(content)
    assert seen.sources(60) is None
    assert seen.features("a") == simulated_features()
    seen.keep_features("a", ["Gain"])
    assert seen.features("a") == ["Gain"]


def test_a_folder_that_cannot_be_written_is_no_failure(tmp_path):
    (tmp_path / "file").touch()
    seen = Seen(tmp_path / "file" / "seen.json")
    seen.keep_sources(FOUND)
    assert seen.sources(60) is None

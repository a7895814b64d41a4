"""The words that completion proposes at each place of a command line."""

import json

import pytest

from grabbergui.setup.bash_line import BashLine
from grabbergui.setup.completion import TABLE, Answer, Completer, for_shell, main
from grabbergui.setup.seen import simulated_values

FOUND = ["gige:192.168.0.10", "u3v:SN1"]


@pytest.fixture
def completer():
    names = {"gige:GV01": ["GainRaw", "ExposureTimeAbs"]}
    table = json.loads(TABLE.read_text("utf-8"))
    values = lambda uri, name: simulated_values().get(name, [])  # noqa: E731
    simulated = ["ExposureTime", "Gain", "TriggerSelector", "LineSelector"]
    return Completer(table, lambda: FOUND, lambda uri: names.get(uri, simulated), values)


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
        ("set sim: ExposureAuto=", ["ExposureAuto=Off", "ExposureAuto=Once", "ExposureAuto=Continuous"]),
        ("set sim: Gain=1 ExposureAuto=O", ["ExposureAuto=Off", "ExposureAuto=Once"]),
        (
            "set sim: TriggerMode[TriggerSelector=FrameStart]=O",
            [
                "TriggerMode[TriggerSelector=FrameStart]=Off",
                "TriggerMode[TriggerSelector=FrameStart]=On",
            ],
        ),
        (
            "set sim: TriggerMode[TriggerSelector=",
            [
                "TriggerMode[TriggerSelector=FrameStart]=",
                "TriggerMode[TriggerSelector=FrameBurstStart]=",
            ],
        ),
        ("set sim: TriggerMode[", ["TriggerMode[TriggerSelector="]),
        ("get sim: TriggerMode[TriggerSelector=FrameS", ["TriggerMode[TriggerSelector=FrameStart]"]),
        ("get gige:GV01 Gain[Ga", []),
        ("set sim: Gain=", []),
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


BREAKS = " \t\n\"'@><=;|&(:"
"""COMP_WORDBREAKS of bash as it comes."""


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("grabbergui ", [""]),
        ("grabbergui get si", ["get", "si"]),
        ("grabbergui get 'sim:", ["get", "sim:"]),
        ("grabbergui get sim: ", ["get", "sim:", ""]),
        ('grabbergui get "', ["get", ""]),
        (r"grabbergui get yarp:/a\ b\;c", ["get", "yarp:/a b;c"]),
        ("grabbergui get 'a\\b'\"c\\d\\$\"", ["get", "a\\bc\\d$"]),
        ("grabbergui get '' x", ["get", "", "x"]),
        ("grabbergui get \\", ["get", ""]),
    ],
)
def test_an_unfinished_line_of_bash_is_split(line, words):
    assert list(BashLine.parse(line).words) == words


@pytest.mark.parametrize(
    ("line", "breaks", "inserted"),
    [
        ("g get gige:", BREAKS, ["", "192.168.0.10"]),
        ("g get gige:", " ", ["gige:", "gige:192.168.0.10"]),
        ("g get 'gige:1", BREAKS, ["gige:", "gige:192.168.0.10"]),
        ("g get gige:'1", BREAKS, ["", "192.168.0.10"]),
        (r"g get gige\:1", BREAKS, ["gige:", "gige:192.168.0.10"]),
    ],
)
def test_bash_gets_what_follows_its_word_breaks(line, breaks, inserted):
    found = Answer({"gige:": "", "gige:192.168.0.10": ""})
    assert for_shell("bash", found, BashLine.parse(line, breaks)).splitlines() == ["words", *inserted]


def test_a_word_that_bash_cannot_quote_is_left_out():
    assert BashLine.parse('g "').inserted("a!b") is None
    assert BashLine.parse("g ").inserted("a!b") == r"a\!b"


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_what_no_shell_shows_as_it_is_is_left_out(shell):
    found = Answer(
        dict.fromkeys(["a\nb", "a\x1b[31m", "a\x07", "a\x9b", "a\u202e", "a\u200b", "a\udc80", "ab"], "")
    )
    line = BashLine.parse("g a") if shell == "bash" else None
    assert for_shell(shell, found, line).splitlines() == ["words", "ab"]


def test_zsh_gets_colons_escaped(completer):
    assert "gige\\:192.168.0.10:found" in for_shell("zsh", completer.answer(["gige:"])).splitlines()


def test_an_unknown_shell_is_refused(capsys):
    assert main(["tcsh", "grabbergui"]) == 2
    assert "bash, zsh, fish" in capsys.readouterr().err

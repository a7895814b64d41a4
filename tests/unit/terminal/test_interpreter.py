"""Typed commands, on the simulated camera."""

from contextlib import ExitStack

import pytest
from prompt_toolkit.completion import CompleteEvent
from prompt_toolkit.document import Document

from grabbergui import sources
from grabbergui.core.errors import FeatureNotFoundError, GrabberError, UsageError
from grabbergui.terminal import Interpreter, answer
from grabbergui.terminal.console import FeatureCompleter
from lost_camera import away
from second_writer import others_stay, ratio


@pytest.fixture(scope="module")
def grabber():
    grabber = sources.create("sim:?width=64&height=48&fps=100")
    grabber.open()
    yield grabber
    grabber.close()


@pytest.fixture
def terminal(grabber, tmp_path):
    return Interpreter(grabber, folder=tmp_path)


def test_features_are_listed_by_a_part_of_their_name(terminal):
    text = terminal.execute("list_features exposure")

    assert "ExposureTime = " in text and "us (10 … " in text and "Width" not in text
    assert len(terminal.execute("list").splitlines()) > 30
    assert "no feature" in terminal.execute("list warp drive")


@pytest.mark.parametrize(
    "line", ["set_feature Width 128", "set Width=128", "set Width = 128", "  set   'Width'  0x80 "]
)
def test_values_are_set_as_one_happens_to_type_them(terminal, line):
    assert terminal.execute(line).startswith("Width = 128 px")
    assert terminal.execute("get_feature Width").startswith("Width = 128 px (16 … ")


def test_what_only_the_stream_locks_is_not_called_read_only(terminal, grabber):
    grabber.start()
    try:
        assert terminal.execute("get PixelFormat").startswith("PixelFormat = Mono8 (one of ")
        assert terminal.execute("set Width 128").startswith("Width = 128 px (16 … ")
        assert "(read-only)" in terminal.execute("get SensorWidth")
    finally:
        grabber.stop()


def test_an_empty_text_is_a_value(terminal, grabber):
    terminal.execute("set DeviceUserID left")
    terminal.execute('set DeviceUserID ""')

    assert grabber.feature("DeviceUserID").value == ""
    for line in ("set DeviceUserID", 'set Gain ""'):
        with pytest.raises(UsageError, match="which value"):
            terminal.execute(line)


def test_automatic_modes(terminal):
    assert terminal.execute("auto ExposureTime").startswith("ExposureAuto = Continuous")
    assert terminal.execute("mode ExposureTime").startswith("ExposureAuto = Continuous")
    assert terminal.execute("auto ExposureTime off").startswith("ExposureAuto = Off")
    assert "set by hand" in terminal.execute("mode Width")


def test_the_stream_and_a_snapshot(terminal, tmp_path):
    assert terminal.execute("start") == "streaming"
    saved = terminal.execute("snapshot images")
    assert saved.startswith("saved ") and len(list((tmp_path / "images").iterdir())) == 1
    assert "frames " in terminal.execute("stats")
    assert terminal.execute("stop") == "stopped"


@pytest.mark.parametrize("line", ["snapshot", "grab 2"])
def test_without_a_stream_no_frame_is_waited_for(terminal, line):
    terminal.execute("stop")
    with pytest.raises(UsageError, match="not streaming; type `start` first"):
        terminal.execute(line)


def test_help_names_every_command_and_exit_ends(terminal):
    assert all(name in terminal.execute("help") for name in terminal.commands)
    assert terminal.execute("") == "" and not terminal.finished
    assert terminal.execute("exit") == "" and terminal.finished


@pytest.mark.parametrize(
    ("line", "error", "message"),
    [
        ("fly", UsageError, "no command 'fly'"),
        ("get", UsageError, "write `get_feature NAME`"),
        ("get a b", UsageError, "write `get_feature NAME`"),
        ("set Width", UsageError, "which value"),
        ("set 'Width", UsageError, "quotation"),
        ("get Warp", FeatureNotFoundError, "no feature Warp"),
        ("grab 101", UsageError, "from 1 to 100"),
        ("watch Gain nan", UsageError, "up to 5"),
        ("auto Width", FeatureNotFoundError, "no automatic mode"),
        ("save ~nobody-of-this-name/a.yaml", UsageError, "no such home directory"),
        ("load ~nobody-of-this-name/a.yaml", UsageError, "no such home directory"),
    ],
)
def test_what_fails_says_why(terminal, line, error, message):
    with pytest.raises(error, match=message):
        terminal.execute(line)
    worked, text = answer(terminal, line)
    assert not worked and message in text


def test_errors_are_all_of_one_tree(terminal):
    with pytest.raises(GrabberError):
        terminal.execute("set Width -1")


@pytest.mark.parametrize(
    ("typed", "completion"),
    [
        ("", "list_features"),
        ("se", "set_feature"),
        ("get ", "Width"),
        ("set Exposure", "ExposureTime"),
        ("set PixelFormat Mono1", "Mono12p"),
        ("run ", "TriggerSoftware"),
    ],
)
def test_completion(grabber, terminal, typed, completion):
    completer = FeatureCompleter(grabber, terminal)

    texts = [found.text for found in completer.get_completions(Document(typed), CompleteEvent())]

    assert completion in texts
    assert typed != "run " or "Width" not in texts


def test_loading_that_a_loss_breaks_off_lists_everything_and_what_is_set_again(
    grabber, terminal, tmp_path, monkeypatch
):
    (tmp_path / "settings.yaml").write_text("features:\n  Gamma: 2\n  BlackLevel: 5\n")
    write = grabber.write_setting
    with ExitStack() as loss:

        def written_last(key, value):
            result = write(key, value)
            loss.enter_context(away(grabber, "the cable is out"))
            return result

        monkeypatch.setattr(grabber, "write_setting", written_last)
        lines = terminal.execute(f"load {tmp_path / 'settings.yaml'}").splitlines()
    assert lines[0] == "written     Gamma: 1 → 2" and lines[1].startswith("not written BlackLevel: ")
    assert lines[2].startswith("interrupted: ") and lines[3] == "1 written, 1 not written"
    assert lines[4] == "what was written is set again when the camera is back, the rest is not"


def test_over_a_network_no_file_is_touched(grabber):
    remote = Interpreter(grabber, remote=True)

    assert "snapshot" not in remote.execute("help")
    for line in ("snapshot /etc", "save /etc/passwd", "load /etc/passwd"):
        with pytest.raises(UsageError, match="there is no command"):
            remote.execute(line)
    assert remote.execute("get Width").startswith("Width")


def test_selecting_and_setting_are_one_step():
    """What is typed for red never lands in green, though somebody else moves the selector all the time."""
    camera = sources.create("sim:?width=64&height=48&pixel_format=BayerRG8")
    camera.open()
    try:
        terminal = Interpreter(camera)
        with others_stay(camera):
            for number in range(40):
                value = f"{2 + number / 100:.10g}"
                assert terminal.execute(f"set {ratio('Red')} {value}").startswith(f"BalanceRatio = {value} ")
                assert terminal.execute(f"get {ratio('Red')}").startswith(f"BalanceRatio = {value} ")
    finally:
        camera.close()

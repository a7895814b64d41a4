"""Completion in the shells themselves."""

import os
import re
import select
import shutil
import subprocess
import sys
import time

import pytest

from grabbergui.core.errors import UsageError
from grabbergui.setup import completion
from patience import PROGRAM

PROGRAM_LINE = [sys.executable, "-m", "grabbergui"]


def ask(shell, line, tmp_path):
    """Return what a shell without the user's own files proposes for a line that is being typed."""
    script = tmp_path / "_grabbergui"
    script.write_text(completion.script(shell, PROGRAM_LINE), "utf-8")
    command = {
        "bash": [
            "bash", "--norc", "-c",
            f"source {script}; COMP_LINE=$1; COMP_POINT=${{#1}}; compopt() {{ echo \"option $*\"; }};"
            '_grabbergui; printf "%s\\n" "${COMPREPLY[@]}"', "bash", line,
        ],
        "fish": ["fish", "--no-config", "-c", f"source {script}; complete -C \"$argv[1]\"", line],
    }[shell]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, timeout=PROGRAM, cwd=tmp_path)
    assert not done.stderr
    return done.stdout.splitlines()


def needs(shell):
    return pytest.mark.skipif(shutil.which(shell) is None, reason=f"{shell} is not installed")


@needs("bash")
def test_bash(tmp_path):
    assert ask("bash", "grabbergui rec", tmp_path) == ["record"]
    assert ask("bash", "grabbergui sim:c", tmp_path) == ["colour"]
    assert ask("bash", "grabbergui set sim: ExposureT", tmp_path) == ["option -o nospace", "ExposureTime="]
    assert ask("bash", "grabbergui save sim: ", tmp_path)[0] == "option -o default"


@needs("fish")
def test_fish(tmp_path):
    (tmp_path / "camera.yaml").touch()
    assert ask("fish", "grabbergui reco", tmp_path) == [
        "record\trecord frames; play them back with file:PATH"
    ]
    assert ask("fish", "grabbergui get sim: ExposureT", tmp_path) == ["ExposureTime"]
    assert ask("fish", "grabbergui save sim: cam", tmp_path) == ["camera.yaml"]


@needs("zsh")
def test_zsh(tmp_path):
    terminal = Zsh(tmp_path)
    try:
        assert terminal.completed("grabbergui reco") == "grabbergui record "
        assert terminal.completed("grabbergui sim:co") == "grabbergui sim:colour "
        assert terminal.completed("grabbergui set sim: ExposureT") == "grabbergui set sim: ExposureTime="
        (tmp_path / "camera.yaml").touch()
        assert terminal.completed("grabbergui save sim: cam") == "grabbergui save sim: camera.yaml "
    finally:
        terminal.close()


class Zsh:
    """An interactive zsh, whose completion needs a terminal."""

    def __init__(self, folder):
        import pty

        (folder / "_grabbergui").write_text(completion.script("zsh", PROGRAM_LINE), "utf-8")
        (folder / ".zshrc").write_text(
            f"fpath=({folder} $fpath); autoload -U compinit; compinit -u -D\n"
            'show() { print -r -- "<$BUFFER>"; BUFFER= }; zle -N show; bindkey "^T" show\n',
            "utf-8",
        )
        self._leader, follower = pty.openpty()
        environment = {**os.environ, "TERM": "dumb", "ZDOTDIR": str(folder)}
        self._process = subprocess.Popen(
            ["zsh", "-d", "-i"], stdin=follower, stdout=follower, stderr=follower, env=environment, cwd=folder
        )
        os.close(follower)

    def completed(self, line):
        """Type a line and the tab key; return what stands in the line then."""
        os.write(self._leader, f"{line}\t\x14".encode())
        shown, ends = "", time.monotonic() + PROGRAM
        while (found := re.search(r"<(.*?)>", shown)) is None:
            assert time.monotonic() < ends, shown
            if select.select([self._leader], [], [], 1)[0]:
                shown += os.read(self._leader, 4096).decode("utf-8", "replace")
        return found[1]

    def close(self):
        """End it."""
        self._process.kill()
        self._process.wait()
        os.close(self._leader)


@pytest.mark.parametrize("shell", completion.SHELLS)
def test_a_script_is_installed_and_removed(shell, tmp_path):
    environment = {"XDG_DATA_HOME": str(tmp_path / "data"), "XDG_CONFIG_HOME": str(tmp_path / "config")}
    file = completion.install(shell, ["/a folder/grabbergui"], environment)
    assert file.is_relative_to(tmp_path) and "'/a folder/grabbergui' --complete" in file.read_text("utf-8")
    assert completion.advice(shell, file)
    assert completion.remove(shell, environment) == file and not file.exists()
    assert completion.remove(shell, environment) is None


def test_the_login_shell_is_chosen():
    assert completion.login_shell({"SHELL": "/usr/bin/zsh"}) == "zsh"
    with pytest.raises(UsageError, match=r"tcsh.*--shell"):
        completion.login_shell({"SHELL": "/bin/tcsh"})

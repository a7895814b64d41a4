"""Remedies that the program applies itself."""

import subprocess

import pytest

from grabbergui.core.errors import SourceUnavailableError
from grabbergui.doctor import mending


@pytest.fixture
def ran(monkeypatch):
    commands = []

    def run(command, **_):
        commands.append(command)
        return subprocess.CompletedProcess(command, 0, "", "")

    monkeypatch.setattr(subprocess, "run", run)
    return commands


def test_a_user_is_asked_for_the_password_and_root_is_not(ran, monkeypatch):
    monkeypatch.setattr(mending.os, "geteuid", lambda: 1000, raising=False)
    monkeypatch.setattr(mending.shutil, "which", lambda name: f"/usr/bin/{name}")
    mending.as_administrator("sysctl", "-w", "a=1")()
    monkeypatch.setattr(mending.os, "geteuid", lambda: 0, raising=False)
    mending.as_administrator("sysctl", "-w", "a=1")()
    assert ran == [["pkexec", "sysctl", "-w", "a=1"], ["sysctl", "-w", "a=1"]]


def test_where_nobody_can_be_asked_there_is_no_button(ran, monkeypatch):
    monkeypatch.setattr(mending.os, "geteuid", lambda: 1000, raising=False)
    monkeypatch.setattr(mending.shutil, "which", lambda name: None)
    assert mending.as_administrator("sysctl") is None


@pytest.mark.parametrize(("message", "reason"), [("no such key\n", "no such key"), ("", "it was refused")])
def test_a_failure_says_what_the_command_said(monkeypatch, message, reason):
    monkeypatch.setattr(mending.os, "geteuid", lambda: 0, raising=False)
    monkeypatch.setattr(
        subprocess, "run", lambda command, **_: subprocess.CompletedProcess(command, 1, "", message)
    )
    with pytest.raises(SourceUnavailableError, match=f"sysctl failed: {reason}"):
        mending.as_administrator("sysctl")()

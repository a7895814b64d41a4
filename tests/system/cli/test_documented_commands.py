"""Commands of README and manual run as they are written, on simulated cameras in place of the named ones.

Times and numbers of frames are shorter. Commands that are not run are listed, with the reason.
"""

from __future__ import annotations

import io
import os
import pkgutil
import re
import shlex
import shutil
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from documented_commands import ENDS, PAGES, ROOT, commands, lines
from grabbergui import sources
from grabbergui.cli import main
from grabbergui.core.pfnc import by_name
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige.server import GigeCamera
from isolation import enter_own_namespaces
from patience import PROGRAM, until

NET = f"127.94.{os.getpid() % 250 + 1}"
"Network of this test run alone: others may run at the same time."
ADDRESSES = (f"{NET}.1", f"{NET}.2")
INSTEAD = (
    (r"\bgige:(GV01|40012345|192\.168\.0\.10)?(?=[ ?]|$)", f"gige:{ADDRESSES[0]}"),
    (r"\bgige:(GV02|192\.168\.0\.11)(?=[ ?]|$)", f"gige:{ADDRESSES[1]}"),
    (r" -t \d+", " -t 0.3"),
    (r" -n \d+", " -n 2"),
    (r" --timeout \d+", " --timeout 0.2"),
    (r"\bfeatures gige", "features --json gige"),
)
"""What takes the place of a camera, a time or a number of frames."""
NOT_RUN = {
    r"simulate .*--gige": "runs until it is ended: `test_a_simulated_camera_runs_until_it_is_ended`",
    r"(gui|terminal|calibrate|servo|hand-eye|experiment|simulate\S*|yarp-server)\b": "runs until it is ended",
    r"serve\b|rig serve": "runs until it is ended: tests/system/cli/test_serve.py",
    r"[\w']+:": "the window: tests/system/ui",
    r"doctor|setup\b": "looks at this computer, or changes it: tests/system/doctor, tests/system/setup",
    r"force-ip|persistent-ip": "changes an address: tests/system/cli/test_gige.py",
    r"events .*--start$": "runs until it is ended: tests/system/cli/test_commands.py",
    r"rig record .*--(before|segment)": "runs until it is ended: tests/system/cli/test_rig_command.py",
    r"rig budget .*--measure": "takes half a minute: tests/system/rig/test_budget_behind_a_switch.py",
    r"run .*TriggerSoftware": "needs a trigger that is on: tests/system/ui/test_trigger_bar.py",
    r".*--monitor": "needs another program with control: tests/system/driver/gige/test_gige_sharing.py",
}
"""Beginnings of commands that are not run, and why; where, if elsewhere."""
OTHER_PROGRAMS = {
    ".venv/bin/pip": "installs packages",
    "apt-get": "installs packages",
    "echo": "changes the kernel",
    "export": "the shell's",
    "nmcli": "needs NetworkManager",
    "pip": "installs packages",
    "python3": "makes an environment, as `make setup` does",
    "ros2": "tests/system/net/ros2/test_ros2cli.py",
    "ufw": "changes the firewall of this computer",
}
"""Programs of others on these pages that are not run here, and why; where, if elsewhere."""
DRY = {"make": ["--dry-run"], ".venv/bin/python": ["--help"]}
"""Options with which a program of others does not do what takes minutes or changes this computer."""
TRIED = {"ip", "sysctl", "python", *DRY}
"""Programs of others that are run by the tests below."""
MAY_FAIL = ("diff", "load", "rig check")
"""Commands whose exit code 1 is a result: settings that differ, a rig with a problem."""

MADE_OF = {"six.yaml": "stereo.yaml", "new.bin": "before.bin"}
"""Files that a page supposes: copies of those that its commands made."""
TABLE = np.arange(4096, dtype="<u2").tobytes()


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder in which a user works who has two cameras, and files that the pages speak of."""
    small = {
        reg.WIDTH: 64,
        reg.HEIGHT: 48,
        reg.EXPOSURE_TIME: 2000.0,
        reg.FRAME_RATE: 50.0,
        reg.PIXEL_FORMAT: by_name("BayerRG8").code,
    }
    cameras = [GigeCamera(address, power_on=small) for address in ADDRESSES]
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sources, "discover", lambda *_, **__: sources.discover_kind("sim"))
    yield tmp_path
    for camera in cameras:
        camera.close()


def not_run(command: str) -> bool:
    return "…" in command or not command or any(re.match(pattern, command) for pattern in NOT_RUN)


def to_run(page: Path) -> list[str]:
    return [command for command in dict.fromkeys(commands(page)) if not not_run(command)]


@pytest.mark.parametrize("page", [page for page in PAGES if to_run(page)], ids=lambda page: page.stem)
def test_commands_do_what_they_did_when_they_were_written_down(
    page: Path, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    failed = {}
    for command in to_run(page):
        line = command
        for pattern, instead in INSTEAD:
            line = re.sub(pattern, instead, line)
        if "put LUTLuminance" in line:
            Path("gamma.bin").write_bytes(TABLE)
        for file, model in MADE_OF.items():
            if file in line and not Path(file).exists():
                shutil.copy(model, file)
        code = main(shlex.split(line))
        printed = capsys.readouterr()
        if code and not (code == 1 and command.startswith(MAY_FAIL)):
            failed[line] = printed.err.strip() or printed.out[-300:]
    assert not failed, "\n".join(f"{line}: {text}" for line, text in failed.items())


def test_what_is_not_run_is_listed_with_its_reason() -> None:
    known = [command for page in PAGES for command in commands(page)]
    assert not [pattern for pattern in NOT_RUN if not any(re.match(pattern, each) for each in known)]
    places = re.findall(r"tests/[\w/.]+", " ".join((*NOT_RUN.values(), *OTHER_PROGRAMS.values())))
    assert places and not [place for place in places if not (ROOT / place).exists()]
    others = {words[0] for page in PAGES for words in lines(page) if Path(words[0]).name != "grabbergui"}
    assert others == OTHER_PROGRAMS.keys() | TRIED
    assert sum(len(to_run(page)) for page in PAGES) > 30


SIMULATED = sorted(
    {
        command
        for page in PAGES
        for command in commands(page)
        if re.match(r"simulate .*--gige", command) and "--twin" not in command  # needs the file of a report
    }
)


@pytest.mark.parametrize("command", SIMULATED)
def test_a_simulated_camera_runs_until_it_is_ended(command: str, monkeypatch: pytest.MonkeyPatch) -> None:
    line = re.sub(r"127\.0\.0\.(\d)", rf"{NET}.1\1", command)
    if NET not in line:
        line = line.replace("--gige", f"--gige {NET}.11")
    printed, ended, ready = io.StringIO(), threading.Event(), []
    monkeypatch.setattr(sys, "stdout", printed)

    def end() -> None:
        """As Ctrl-C does, once the camera is there."""
        until(lambda: f"is at {NET}.11" in printed.getvalue() or ended.is_set())
        if not ended.is_set():
            ready.append(line)
            signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)

    ender = threading.Thread(target=end)
    ender.start()
    code = main(shlex.split(line))
    ended.set()
    ender.join()
    assert (code, ready) == (0, [line])


def of_others(program: str) -> list[list[str]]:
    """Return the words of each line of the pages that begins with a program of others."""
    found = []
    for page in PAGES:
        for words in lines(page):
            if words[0] == program:
                end = next((index for index, word in enumerate(words) if word in ENDS), len(words))
                found.append(words[:end])
    return found


def ran(command: list[str]) -> str:
    """Run a command in the repository; return what it printed if it failed."""
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=PROGRAM)
    return f"{shlex.join(command)}: {done.stdout[-300:]}{done.stderr[-300:]}" if done.returncode else ""


@pytest.mark.parametrize("program", DRY)
def test_a_program_of_others_has_what_a_page_asks_of_it(program: str) -> None:
    failed = []
    for words in of_others(program):
        command = [*words, *DRY[program]]
        if program == ".venv/bin/python":
            command = [sys.executable, words[1], *DRY[program]]
        failed.append(ran(command))
    assert failed and not any(failed), "\n".join(failed)


def test_every_benchmark_of_a_page_is_one() -> None:
    pytest.importorskip("benchmarks", reason="benchmarks/ is found from the checkout: python -m pytest")
    pytest.importorskip("benchmarks.servo", reason="pages name benchmarks of servo, which is not here")
    import benchmarks

    names = {
        module.name.rpartition(".")[2] for module in pkgutil.walk_packages(benchmarks.__path__, "benchmarks.")
    }
    named = {words[3] for words in of_others("python") if words[1:3] == ["-m", "benchmarks"]}
    assert named and named <= names


@pytest.mark.netns
@pytest.mark.skipif(sys.platform != "linux", reason="these are Linux's programs")
def test_commands_for_the_network_are_taken_by_the_kernel() -> None:
    """Of the interfaces in a network of the test's own, and of the settings that this kernel has."""
    if os.geteuid() != 0 or not shutil.which("ip"):
        pytest.skip("a network of its own needs root and `ip` (Debian: iproute2)")
    failed = []

    def run() -> None:
        enter_own_namespaces()
        for interface in ("eth0", "eth1"):
            assert not ran(
                ["ip", "link", "add", interface, "type", "veth", "peer", "name", f"{interface}peer"]
            )
        failed.extend(ran(words) for words in of_others("ip"))

    with ThreadPoolExecutor(1) as pool:
        pool.submit(run).result()
    assert failed and not any(failed), "\n".join(failed)
    for words in of_others("sysctl"):
        name, _, value = words[-1].partition("=")
        assert Path("/proc/sys", name.replace(".", "/")).exists() and int(value) > 0

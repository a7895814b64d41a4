"""A screen with a window manager, cameras that can be lost, and the hands of an operator."""

from __future__ import annotations

import contextlib
import json
import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from grabbergui.core.errors import GrabberError
from grabbergui.driver.gige.control_link import ControlLink
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige import registers as gev
from grabbergui.driver.sim.memory import Register
from patience import PATIENCE, PROGRAM, until

PROGRAMS = ("Xvfb", "openbox", "xdotool")
OBSERVER = Path(__file__).with_name("observer.py")
SETTLED = 0.15
"Seconds for which a widget keeps its place before it is aimed at."


@contextlib.contextmanager
def screen(width: int, height: int) -> Iterator[dict[str, str]]:
    """A screen of that many pixels, with a window manager; the environment of its programs."""
    with contextlib.ExitStack() as stack:
        reading, writing = os.pipe()
        with os.fdopen(reading) as numbers:
            # Without -noreset it would throw the window manager out when xdotool, its first client, has gone.
            command = ["Xvfb", "-displayfd", str(writing), "-noreset", "-nolisten", "tcp"]
            command += ["-screen", "0", f"{width}x{height}x24"]
            stack.enter_context(_program(command, pass_fds=[writing]))
            os.close(writing)
            display = f":{numbers.readline().strip()}"
        environment = {**os.environ, "DISPLAY": display}
        stack.enter_context(_program(["openbox", "--sm-disable"], env=environment))
        # Without a window manager nothing answers which window is active.
        until(lambda: "not to support" not in _xdotool(environment, "getactivewindow")[1], "a window manager")
        yield environment


@contextlib.contextmanager
def _program(command: list[str], **options: Any) -> Iterator[subprocess.Popen[str]]:
    options = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "text": True, **options}
    process = subprocess.Popen(command, **options)
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def _xdotool(environment: dict[str, str], *arguments: str | int) -> tuple[int, str]:
    command = ["xdotool", *map(str, arguments)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=PATIENCE)
    return done.returncode, done.stdout + done.stderr


class Camera:
    """A simulated GigE Vision camera in a process of its own; its registers are read past the window."""

    def __init__(self, address: str, serial: str, **values: str | int) -> None:
        self.address, self.serial = address, serial
        self._values = values
        self._process: subprocess.Popen[str] | None = None
        self.answers = False
        """Whether it has power and its cable is plugged in."""

    @property
    def uri(self) -> str:
        return f"gige:{self.address}"

    def begin(self) -> None:
        """Switch it on."""
        values = "&".join(f"{name}={value}" for name, value in self._values.items())
        command = [sys.executable, "-m", "grabbergui", "simulate", "--gige", self.address,
                   "--serial", self.serial, "--camera", f"sim:?{values}"]  # fmt: skip
        self._process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert self._process.stdout is not None and self.serial in self._process.stdout.readline()
        self.answers = True

    def lose_power(self) -> None:
        """Forget all that was set."""
        self.answers = False
        if self._process is not None:
            self._process.kill()
            self._process.communicate()
            self._process = None

    def pull_cable(self) -> None:
        """Fall silent, and forget nothing."""
        assert self._process is not None
        self._process.send_signal(signal.SIGSTOP)
        self.answers = False

    def plug_cable(self) -> None:
        """Speak again."""
        assert self._process is not None
        self._process.send_signal(signal.SIGCONT)
        self.answers = True

    def register(self, register: Register) -> Any:
        """Return the current value of a register."""
        return register.decode(until(lambda: self._read(register), f"an answer of {self.serial}"))

    def _read(self, register: Register) -> bytes:
        """Nothing where the camera answers what somebody before us asked from the same port."""
        with contextlib.suppress(GrabberError), contextlib.closing(ControlLink(self.address)) as link:
            return link.read_memory(register.address, register.length)
        return b""

    @property
    def exposure(self) -> float:
        """In microseconds."""
        return self.register(reg.EXPOSURE_TIME)

    @property
    def triggered(self) -> bool:
        return bool(self.register(reg.TRIGGER_MODE[0]))

    @property
    def streams(self) -> bool:
        """Whether it sends frames to somebody: GigE Vision's stream channel has a port."""
        return bool(self.register(gev.CHANNELS[0].scp) & 0xFFFF)


class Operator:
    """A window of the program on a screen, the hands that use it, and what it says."""

    def __init__(self, environment: dict[str, str], home: Path, *arguments: str) -> None:
        self._environment = {
            **environment,
            "HOME": str(home),
            "XDG_CONFIG_HOME": str(home / "config"),
            "XDG_RUNTIME_DIR": str(home),
            "QT_QPA_PLATFORM": "xcb",
        }
        command = [
            sys.executable,
            "-m",
            "grabbergui",
            "gui",
            "--log-level",
            "error",
            "--script",
            str(OBSERVER),
            *arguments,
        ]
        self.errors = (home / "stderr.txt").open("w+")
        self.process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self.errors,
            text=True,
            env=self._environment,
            cwd=home,
        )
        assert self._answer(PROGRAM) == "ready"
        self.until("window.isActiveWindow()")
        self._shots = 0
        self.folder = (
            Path(os.environ["GRABBERGUI_ARTEFACTS"]) if "GRABBERGUI_ARTEFACTS" in os.environ else None
        )

    def ask(self, expression: str) -> Any:
        """Evaluate an expression in the observer's process, while the window lives."""
        assert self.process.stdin is not None
        self.process.stdin.write(expression + "\n")
        self.process.stdin.flush()
        return self._answer(PATIENCE)

    def said(self) -> dict[str, Any]:
        """Return the state, figures and messages that the window shows for each camera."""
        answer = self.ask("said()")
        assert isinstance(answer, dict)
        return answer

    def until(self, expression: str) -> Any:
        """Wait until an expression is true."""
        return until(lambda: self.ask(expression), expression)

    def _answer(self, seconds: float) -> Any:
        assert self.process.stdout is not None
        ready, _, _ = select.select([self.process.stdout], [], [], seconds)
        line = self.process.stdout.readline() if ready else ""
        # GenApi writes to stdout, too, when a program ends; what the window wrote says why it ended.
        is_answer = line.startswith("{")
        assert is_answer, (
            f"no answer ({line!r}); exit status {self.process.poll()}; stderr:\n{self.complaints()}"
        )
        reply = json.loads(line)
        assert "error" not in reply, reply["error"]
        return reply["answer"]

    def complaints(self) -> str:
        """Return what the program has written to stderr so far."""
        self.errors.seek(0)
        return self.errors.read()

    def is_writing(self, part: str) -> bool:
        """Whether the program holds a file open whose path contains this."""
        links = Path(f"/proc/{self.process.pid}/fd").iterdir()
        return any(part in target for target in map(_target, links))

    def keys(self, *keys: str) -> None:
        """Press keys one after the other, as "ctrl+z"."""
        self._do("key", "--clearmodifiers", "--delay", 20, *keys)

    def type(self, text: str) -> None:
        """Type a text, and see it in the field: on a busy machine the window is behind the hands."""
        self._do("type", "--delay", 5, text)
        self.until(f"typed().endswith({text!r})")

    def point(self, widget: str, x: float = 0.5, y: float = 0.5) -> None:
        """Bring the mouse over a widget, once it can be seen and stands still."""
        seen: list[tuple[float, Any]] = []

        def settled() -> Any:
            now, place = time.monotonic(), self.ask(f"place({widget}, {x}, {y})")
            if not seen or seen[-1][1] != place:
                seen.append((now, place))
            return place if now - seen[-1][0] >= SETTLED else None

        try:
            place = until(settled, f"{widget} where it can be clicked")
        except AssertionError as error:
            raise AssertionError(f"{error}: {self.ask(f'hindrance({widget}, {x}, {y})')}") from None
        self._do("mousemove", *place)

    def click(self, widget: str, x: float = 0.5, y: float = 0.5) -> None:
        """Click on a widget."""
        self.point(widget, x, y)
        self._do("click", 1)

    def drag(self, widget: str, x: float, by: int) -> None:
        """Drag from a place of a widget, to the right by so many pixels."""
        self.point(widget, x)
        step = 1 if by > 0 else -1
        self._do("mousedown", 1, *("mousemove_relative", "--", step, 0) * abs(by), "mouseup", 1)

    def wheel(self, widget: str, notches: int) -> None:
        """Turn the wheel over a widget; up where positive."""
        self.point(widget)
        self._do("click", "--repeat", abs(notches), "--delay", 20, 4 if notches > 0 else 5)

    def resize(self, width: int, height: int) -> None:
        """As with the mouse at the window's edge: the size that the window manager is asked for."""
        # Qt knows that its window is active before the window manager has said so to everybody.
        until(lambda: not _xdotool(self._environment, "getactivewindow")[0], "an active window")
        self._do("getactivewindow", "windowsize", "--sync", width, height)

    def shot(self, name: str) -> None:
        """Keep an image of the screen in the folder that GRABBERGUI_ARTEFACTS names, if it does."""
        if self.folder is not None:
            folder = self.folder / "day"
            folder.mkdir(parents=True, exist_ok=True)
            self._shots += 1
            assert self.ask(f"shot({str(folder / f'{self._shots:02d}-{name}.png')!r})")

    def _do(self, *arguments: str | int) -> None:
        code, output = _xdotool(self._environment, *arguments)
        assert code == 0, output

    def close(self) -> None:
        """End the program if it still runs."""
        if self.process.poll() is None:
            self.shot("left open")
            self.process.kill()
        self.process.communicate()
        self.errors.close()


def _target(link: Path) -> str:
    try:
        return str(link.readlink())
    except OSError:  # closed meanwhile
        return ""

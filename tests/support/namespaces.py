"""Network namespaces for tests: a host and a camera, joined by virtual cables, and programs in them."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from patience import PATIENCE

HERE = Path(__file__).parent
CAMERA, HOST = "10.77.0.1", "10.77.0.2"
LOSS, DELAY_MS, JITTER_MS, REORDER = 0.01, 5.0, 1.0, 0.25


def run(*command: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE)


class Programs:
    """Programs started in namespaces, all ended on leaving."""

    def __init__(self, stack: contextlib.ExitStack) -> None:
        self._stack = stack

    def start(self, namespace: str, *command: str, **environment: str) -> subprocess.Popen[str]:
        enter = ["ip", "netns", "exec", namespace] if namespace else []
        process = subprocess.Popen(
            [*enter, sys.executable, *command],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env={**os.environ, **environment},
        )
        self._stack.callback(self._end, process)
        return process

    @staticmethod
    def _end(process: subprocess.Popen[str]) -> None:
        process.terminate()
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(PATIENCE)
        process.kill()
        process.wait()
        for pipe in (process.stdin, process.stdout):
            assert pipe is not None
            pipe.close()


class Network:
    """Two namespaces and what joins them."""

    def __init__(self, stack: contextlib.ExitStack) -> None:
        self.programs = Programs(stack)
        self.camera, self.host = (f"gg{os.getpid()}{end}" for end in "ch")
        self.device = "eth0"
        for namespace in (self.camera, self.host):
            made = run("ip", "netns", "add", namespace)
            if made.returncode:
                pytest.skip(f"no network namespaces here: {made.stderr.strip()}")
            stack.callback(run, "ip", "netns", "del", namespace)
            run("ip", "-n", namespace, "link", "set", "lo", "up")

    def join(self, device: str = "eth0", camera: str = CAMERA, host: str = HOST) -> None:
        """By a pair of virtual Ethernet devices."""
        made = run(
            *("ip", "link", "add", device, "netns", self.camera, "type", "veth"),
            *("peer", "name", device, "netns", self.host),
        )
        if made.returncode:
            pytest.skip(f"no virtual Ethernet devices here: {made.stderr.strip()}")
        for namespace, address in ((self.camera, camera), (self.host, host)):
            run("ip", "-n", namespace, "addr", "add", f"{address}/24", "dev", device)
            run("ip", "-n", namespace, "link", "set", device, "up")

    def impair(self) -> bool:
        """Make the joint a bad one by netem; whether the kernel can."""
        netem = f"netem loss {LOSS:%} delay {DELAY_MS}ms {JITTER_MS}ms reorder {REORDER:%} limit 20000"
        made = [
            run("tc", "-n", namespace, "qdisc", "add", "dev", self.device, "root", *netem.split())
            for namespace in (self.camera, self.host)
        ]
        return not any(result.returncode for result in made)

    def join_badly(self) -> None:
        """By a cable that is as bad as netem would make it."""
        wire = self.programs.start(
            "",
            str(HERE / "lossy_wire.py"),
            *(self.camera, self.device, f"{CAMERA}/24", self.host, self.device, f"{HOST}/24"),
            *(str(figure) for figure in (LOSS, DELAY_MS, JITTER_MS, REORDER)),
        )
        assert wire.stdout is not None
        if wire.stdout.readline() != "ready\n":
            pytest.skip("neither netem nor tap devices here")

    def set_link(self, state: str) -> None:
        """Pull the host's cable (`down`), or put it back (`up`)."""
        assert not run("ip", "-n", self.host, "link", "set", self.device, state).returncode

    def start_camera(
        self, settings: str, address: str = CAMERA, device: str = "eth0", *options: str
    ) -> subprocess.Popen[str]:
        camera = self.programs.start(
            self.camera, "-m", "grabbergui", "simulate", "--gige", address, "--camera", settings, *options,
            GRABBERGUI_INTERFACES=device,
        )  # fmt: skip
        assert camera.stdout is not None
        assert address in camera.stdout.readline()
        return camera


class Host:
    """The program that streams, and its reports."""

    def __init__(self, network: Network, uri: str, interfaces: str | None = None) -> None:
        """`interfaces`: those that it may use; by default the one to the camera, empty for all."""
        allowed = network.device if interfaces is None else interfaces
        self._process = network.programs.start(
            network.host, str(HERE / "in_namespace.py"), uri, GRABBERGUI_INTERFACES=allowed
        )

    def wait_for(self, what: str) -> dict[str, Any]:
        """Return its next report of this kind."""
        assert self._process.stdout is not None
        for line in self._process.stdout:
            reported: dict[str, Any] = json.loads(line)
            if reported["what"] == what:
                return reported
        raise AssertionError(f"the host ended without reporting {what}")

    def end(self) -> dict[str, Any]:
        """Its statistics."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        return self.wait_for("end")


@pytest.fixture
def network() -> Iterator[Network]:
    if sys.platform != "linux" or os.geteuid() != 0:
        pytest.skip("network namespaces need Linux and root")
    with contextlib.ExitStack() as stack:
        yield Network(stack)

"""The virtual machine with a real USB stack, which does its work while other tests do theirs."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import pytest

HERE = Path(__file__).parent
REPOSITORY = HERE.parents[2]

GUEST_SECONDS = 1000
"""A minute or two where nothing else runs, many times that on a busy machine."""
NO_GUEST = 77
"""The exit status of `usbvm` where no guest can be made."""


class Guest:
    """One boot that runs `in_guest.py` for every way of being a USB device."""

    def __init__(self) -> None:
        """Start it, behind everything else that wants the machine's cores."""
        self._said = tempfile.TemporaryFile("w+", errors="replace")  # noqa: SIM115 (closed by `end`)
        self._process = subprocess.Popen(
            [
                *("nice", "-n", "5", HERE / "usbvm", "-t", str(GUEST_SECONDS), "--"),
                *(sys.executable, HERE / "in_guest.py", "vhci", "gadget"),
            ],
            cwd=REPOSITORY,
            stdin=subprocess.DEVNULL,
            stdout=self._said,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )

    def result(self) -> dict[str, Any]:
        """Wait for what the hosts in the guest saw, by the way the camera is a USB device there."""
        status = self._process.wait(GUEST_SECONDS + 400)  # a kernel may have to be fetched first
        self._said.seek(0)
        said = self._said.read()
        if status == NO_GUEST:
            pytest.skip(said.strip())
        results = [line for line in said.splitlines() if line.startswith("RESULT ")]
        assert results, f"the guest said:\n{said[-4000:]}"
        result: dict[str, Any] = json.loads(results[0].removeprefix("RESULT "))
        return result

    def end(self) -> None:
        """Nothing of it is left, however far it has come."""
        if self._process.poll() is None:
            os.killpg(self._process.pid, signal.SIGTERM)
            self._process.wait()
        self._said.close()

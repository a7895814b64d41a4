"""The virtual machine with real USB and video drivers, which does its work while other tests do theirs."""

from __future__ import annotations

import faulthandler
import json
import sys
import sysconfig
from pathlib import Path
from typing import Any

import pytest

import isolation
from patience import until

HERE = Path(__file__).parent
REPOSITORY = HERE.parents[1]

GUEST_SECONDS = 800
"""A minute where nothing else runs; beside twenty busy programs 500 s were too few."""
NO_GUEST = 77
"""The exit status of `usbvm` where no guest can be made."""


class Guest:
    """One boot that runs `in_guest.py` for every kind of camera that it tries.

    Tests may be spread over several processes: one of them starts it, and all can ask for the result.
    """

    def __init__(self, folder: Path) -> None:
        """`folder` is common to all processes of this run of the tests."""
        self._said = folder / "guest.txt"
        self._status = folder / "guest.status"

    def start(self) -> None:
        """Start it, behind everything else that wants the machine's cores. Once in a run.

        The guest's kernel is kept for later runs, which need not fetch and unpack it again.
        """
        part = f"{self._status}.part"
        command = f'"$@" >"{self._said}" 2>&1; echo $? >"{part}"; mv "{part}" "{self._status}"'
        isolation.start_for_the_run(
            [
                *("nice", "-n", "5", "env", f"XDG_CACHE_HOME={REPOSITORY / 'build'}"),
                *("sh", "-c", command, "sh"),
                *(HERE / "usbvm", "-t", str(GUEST_SECONDS), "--"),
                # -S: the .pth file of ROS 2's wheels starts Python a second time, which is slow in emulation.
                *("env", f"PYTHONPATH={REPOSITORY}:{sysconfig.get_path('purelib')}", sys.executable, "-S"),
                *(HERE / "in_guest.py", "vhci", "gadget", "webcam"),
            ],
            cwd=REPOSITORY,
        )

    def result(self) -> dict[str, Any]:
        """Wait for what the hosts in the guest saw, by the kind of camera."""
        faulthandler.cancel_dump_traceback_later()  # this wait may be longer than what counts as a hang
        # A kernel may have to be fetched first.
        until(self._status.exists, "the virtual machine's end", GUEST_SECONDS + 150)
        status = int(self._status.read_text())
        said = self._said.read_text(errors="replace")
        if status == NO_GUEST:
            pytest.skip(said.strip())
        results = [line for line in said.splitlines() if line.startswith("RESULT ")]
        assert results, f"the guest said:\n{said[-4000:]}"
        result: dict[str, Any] = json.loads(results[0].removeprefix("RESULT "))
        return result

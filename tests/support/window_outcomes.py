"""Runs a program that shows windows, `each_window.py` or one like it."""

import json
import os
import subprocess
import sys

from patience import PROGRAM


def window_outcomes(program, cases, folder):
    """Show the windows of these cases in a folder; return of each its arguments, exit status and stderr."""
    own = {"HOME": folder, "XDG_RUNTIME_DIR": folder, "PYTHONPATH": os.pathsep.join(sys.path)}
    run = subprocess.run(
        [sys.executable, str(program)],
        input=json.dumps(cases),
        stdout=subprocess.PIPE,
        text=True,
        timeout=PROGRAM * len(cases),
        cwd=folder,
        env=os.environ | own,
    )
    assert run.returncode == 0
    outcomes = [json.loads(line) for line in run.stdout.splitlines() if line.startswith("[")]
    return [(case[0], *outcome) for case, outcome in zip(cases, outcomes, strict=True)]

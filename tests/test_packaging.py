"""The source distribution has everything that the repository has."""

import fnmatch
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
BY_ITSELF = {"grabbergui", "pyproject.toml", "setup.py", "LICENSE", "COPYING.exception", "MANIFEST.in"}
"""What setuptools adds without being told."""


def test_every_file_of_the_repository_is_in_the_source_distribution():
    try:
        listed = subprocess.run(
            ["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True
        ).stdout
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("this is no git repository")
    patterns = BY_ITSELF.copy()
    for line in (ROOT / "MANIFEST.in").read_text("utf-8").splitlines():
        command, *names = line.split()
        if command in ("include", "graft"):
            patterns.update(names)
    top = {path.split("/")[0] for path in listed.splitlines()}
    assert not [name for name in top if not any(fnmatch.fnmatchcase(name, each) for each in patterns)]

"""GenTL producers for GigE Vision that a camera maker supplies, where one is installed.

For example Baumer's `libbgapi2_gige.cti`, which their SDK and Roboception's rc_genicam_api contain.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest


def producer() -> Path | None:
    """A producer in a folder of GENICAM_GENTL64_PATH."""
    folders = os.environ.get("GENICAM_GENTL64_PATH", "").split(os.pathsep)
    found = (file for folder in folders if folder for file in Path(folder).glob("*gige*.cti"))
    return next(found, None)


needs_producer = pytest.mark.skipif(
    producer() is None, reason="no folder of GENICAM_GENTL64_PATH has a GenTL producer for GigE Vision"
)

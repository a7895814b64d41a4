"""Descriptions loaded into GenApi without holding up the other threads.

GenApi's binding keeps the GIL while it parses: 100 ms for a camera of 3,500 nodes, in which the window does
not answer. Four fifths of that are the XML itself, whose result GenApi can put into a cache (the folder that
GENICAM_CACHE_V… names, GenICam Package documentation): so a large description is parsed in a process of its
own, and this process reads the result.
"""

from __future__ import annotations

import logging
import os
import re
import secrets
import shutil
import subprocess
import sys
import tempfile
import threading
from pathlib import Path

import genicam
from genicam import genapi

LARGE = 300_000
"Characters of a description beyond which the detour is worth a process (0.15 s)."
PATIENCE = 5.0
"Seconds that the other process gets before this one parses for itself."

_PARSE = (
    "import sys; from genicam import genapi;"
    "genapi.NodeMap().load_xml_from_string(sys.stdin.buffer.read().decode())"
)
_loading = threading.Lock()
"Also for small ones: a cache must not vanish while GenApi looks into it."
log = logging.getLogger(__name__)


def _cache_variable() -> str:
    """The variable in which the GenApi that is installed looks for its cache; it names the version."""
    for library in Path(genicam.__file__).parent.glob("*GenApi_*"):
        if version := re.search(r"_v(\d+_\d+)\.", library.name):
            return f"GENICAM_CACHE_V{version[1]}"
    return ""


def _private_cache() -> Path | None:
    """A folder that exists only while a large description is loaded; without it, GenApi goes without cache.

    So the variable is set once, since changing the environment under running threads is not safe. None where
    a vendor's installation has set a cache of its own, which then does the same.
    """
    variable = _cache_variable()
    if not variable or variable in os.environ:
        return None
    folder = Path(tempfile.gettempdir()) / f"grabbergui-{secrets.token_hex(8)}"
    os.environ[variable] = str(folder)
    return folder



def load(xml: str) -> genapi.NodeMap:
    """A node map of this description, without a port. Any thread; one after another.

    Raises what GenApi raises for a description that it cannot use.
    """
    nodes = genapi.NodeMap()
    with _loading:
        if len(xml) < LARGE or _cache is None:
            nodes.load_xml_from_string(xml)
            return nodes
        try:
            _fill_cache(_cache, xml)
            nodes.load_xml_from_string(xml)
        finally:
            shutil.rmtree(_cache, ignore_errors=True)
    return nodes


def _fill_cache(folder: Path, xml: str) -> None:
    try:
        folder.mkdir(mode=0o700)
        subprocess.run(
            [sys.executable, "-c", _PARSE],
            input=xml.encode(),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            timeout=PATIENCE,
            check=True,
        )
    except (OSError, subprocess.SubprocessError) as error:
        log.debug("the description is parsed by this process: %s", error)
        shutil.rmtree(folder, ignore_errors=True)  # GenApi takes half a result for a broken one


_cache = _private_cache()

"""Descriptions loaded into GenApi without harm to the other threads, or to other programs.

GenApi's binding holds the GIL while it parses: 100 ms for a camera of 3,500 nodes, in which the window does
not answer. Four fifths of that are the XML itself, so a process of its own parses a large description, and
this process reads the result (`parse_cache`), also of descriptions that it loaded before.
"""

from __future__ import annotations

import sys
import threading

from genicam import genapi

from grabbergui.driver.genapi.vetting import vetted

if sys.platform == "linux":
    from grabbergui.driver.genapi import parse_cache

LARGE = 300_000
"Characters of a description beyond which the detour is worth a process (0.15 s)."

_loading = threading.Lock()
"Also for small ones: while the cache is switched on, GenApi uses it for every description."


def load(xml: str) -> genapi.NodeMap:
    """A node map of this description, without a port. Any thread; one after another.

    Raises RemoteProtocolError for a description that `vetting` or GenApi's own process cannot stand, and what
    GenApi raises for one that it cannot use.
    """
    nodes = genapi.NodeMap()
    with _loading:
        if sys.platform == "linux" and len(xml) >= LARGE:
            with parse_cache.parsed(xml) as text:
                nodes.load_xml_from_string(text)
        else:
            nodes.load_xml_from_string(vetted(xml))
    return nodes

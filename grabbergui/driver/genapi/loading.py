"""Loads GenApi's node maps.

GenApi's binding holds the GIL while it parses: 100 ms for a camera of 3,500 nodes, during which the window is
frozen. Four fifths of that time go into the XML, so a separate process parses a large description and this
process reads the result (`parse_cache`), which is also kept for the next time.
"""

from __future__ import annotations

import sys
import threading

from genicam import genapi

from grabbergui.driver.genapi.vetting import vetted

if sys.platform == "linux":
    from grabbergui.driver.genapi import parse_cache

LARGE_XML = 300_000
"Characters of a description from which a separate process (0.15 s) pays off."

_loading = threading.Lock()
"Needed for small descriptions too: while the cache is on, GenApi uses it for all of them."


def load(xml: str) -> genapi.NodeMap:
    """Return the node map of a description, without a port. Any thread; calls are serialised.

    Raises RemoteProtocolError for a description that `vetting` refuses or that crashes the parsing process,
    and GenApi's exceptions for one that it cannot use.
    """
    nodes = genapi.NodeMap()
    with _loading:
        if sys.platform == "linux" and len(xml) >= LARGE_XML:
            with parse_cache.parsed(xml) as text:
                nodes.load_xml_from_string(text)
        else:
            nodes.load_xml_from_string(vetted(xml))
    return nodes

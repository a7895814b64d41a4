"""A ROS domain that no other test on this machine is in, for the life of this process."""

from __future__ import annotations

import fcntl
import functools
import random
import tempfile
from pathlib import Path
from typing import IO

_DOMAINS = range(1, 101)
"""Above 101 ROS's ports lie where the system takes ports for others."""


@functools.cache
def own_domain() -> dict[str, str]:
    """The environment variables for it: nobody else's nodes, and none of ours beyond this machine."""
    global _held
    for domain in random.sample(_DOMAINS, len(_DOMAINS)):
        lock = (Path(tempfile.gettempdir()) / f"grabbergui-test-ros-domain-{domain}").open("w")
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            lock.close()
            continue
        _held = lock
        return {"ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    raise RuntimeError("a hundred ROS domains are in use")


_held: IO[str] | None = None
"""Keeps the lock."""

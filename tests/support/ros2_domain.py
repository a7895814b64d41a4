"""Chooses a ROS domain that no other test on this machine uses, for the life of this process."""

from __future__ import annotations

import fcntl
import functools
import random
import tempfile
from importlib import resources
from pathlib import Path
from typing import IO

import isolation

_DOMAINS = range(1, 101)
"""Above 101 ROS's ports lie where the system takes ports for others."""


@functools.cache
def own_domain() -> dict[str, str]:
    """Return the environment variables that keep nodes in this domain and on this machine."""
    global _held
    for domain in random.sample(_DOMAINS, len(_DOMAINS)):
        lock = (Path(tempfile.gettempdir()) / f"grabbergui-test-ros-domain-{domain}").open("w")
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            lock.close()
            continue
        _held = lock
        return {
            "ROS_DOMAIN_ID": str(domain),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "FASTDDS_DEFAULT_PROFILES_FILE": str(_profile_for_small_images()),
        }
    raise RuntimeError("a hundred ROS domains are in use")


_held: IO[str] | None = None
"""Keeps the lock."""


def _profile_for_small_images() -> Path:
    """Write our profile with 8 instead of 64 MiB for each node, which fills them when it is made."""
    ours = (resources.files("grabbergui.resources") / "ros2" / "fastdds.xml").read_text("utf-8")
    assert "<segment_size>67108864<" in ours
    path = isolation.run_folder() / f"fastdds-{isolation.WORKER}.xml"
    path.write_text(ours.replace("<segment_size>67108864<", "<segment_size>8388608<"), "utf-8")
    return path

"""Chooses a ROS domain that no other test on this machine uses, for the life of this process."""

from __future__ import annotations

import fcntl
import functools
import os
import random
import tempfile
from importlib import resources
from pathlib import Path

import isolation

_DOMAINS = range(1, 101)
"""Above 101 ROS's ports lie where the system takes ports for others."""


@functools.cache
def own_domain() -> dict[str, str]:
    """Return the environment variables that keep nodes in this domain and on this machine."""
    for domain in random.sample(_DOMAINS, len(_DOMAINS)):
        name = Path(tempfile.gettempdir()) / f"grabbergui-test-ros-domain-{domain}"
        lock = os.open(name, os.O_CREAT | os.O_RDWR)  # kept until the process ends
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            os.close(lock)
            continue
        return {
            "ROS_DOMAIN_ID": str(domain),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "FASTDDS_DEFAULT_PROFILES_FILE": str(_profile_for_small_images()),
        }
    raise RuntimeError("a hundred ROS domains are in use")


def _profile_for_small_images() -> Path:
    """Write our profile with 8 instead of 64 MiB for each node, which fills them when it is made."""
    ours = (resources.files("grabbergui.resources") / "ros2" / "fastdds.xml").read_text("utf-8")
    assert "<segment_size>67108864<" in ours
    path = isolation.run_folder() / f"fastdds-{isolation.WORKER}.xml"
    path.write_text(ours.replace("<segment_size>67108864<", "<segment_size>8388608<"), "utf-8")
    return path

"""A camera and a host in two network namespaces: two hosts as far as the kernel is concerned.

Loss, delay and reordering come from `tc netem` where the kernel has it, else from a cable of our own.
"""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable

import pytest

from in_namespace import EXPOSURE, MANY
from namespaces import CAMERA, LOSS, Host, Network, network, run
from patience import TRIES, allowance

PULL_SECONDS = 3.0
MISSED_SECONDS = RECOVERY_SECONDS = 2.0

pytestmark = pytest.mark.netns
__all__ = ["network"]


@pytest.fixture
def report(record_property: Callable[[str, object], None]) -> Callable[..., None]:
    """Figures into the test report, and to those who run with -s."""

    def record(**figures: object) -> None:
        for name, figure in figures.items():
            record_property(name, figure)
        print(json.dumps(figures))

    return record


def test_a_bad_network_costs_no_frame(network: Network, report: Callable[..., None]) -> None:
    network.join()
    netem = network.impair()
    if not netem:
        run("ip", "-n", network.host, "link", "del", network.device)
        network.join_badly()
    # Few packets, as the cable in Python has to keep up on a busy machine too.
    network.start_camera("sim:?width=320&height=240&fps=30")
    for _ in range(TRIES):  # a cable that waits for the processor too long loses more than it should
        host = Host(network, f"gige:{CAMERA}?packet_size=1400")
        host.wait_for("many")
        time.sleep(float(os.environ.get("GRABBERGUI_NETNS_SECONDS", "0")))
        reported = host.end()
        asked = reported["frames"] + reported["incomplete"] + reported["lost"]
        if reported["frames"] >= 0.999 * asked:
            break
    report(netem=netem, **reported)
    assert asked >= MANY
    assert reported["frames"] >= 0.999 * asked
    assert reported["packets_resent"] > 0.5 * LOSS * reported["packets"], "this was no bad network"


def test_a_cable_that_was_out_for_three_seconds(network: Network, report: Callable[..., None]) -> None:
    network.join()
    network.start_camera("sim:?width=640&height=480&fps=20")
    host = Host(network, f"gige:{CAMERA}")
    host.wait_for("frame")
    for _ in range(TRIES):  # processes that others keep waiting for seconds say nothing about us
        missed, recovered = (seconds / allowance() for seconds in pull_cable(network, host))
        if missed < MISSED_SECONDS and recovered < RECOVERY_SECONDS:
            break
    reported = host.end()
    report(missed_after=missed, frame_after=recovered)
    assert missed < MISSED_SECONDS and recovered < RECOVERY_SECONDS
    assert reported["exposure"] == EXPOSURE and reported["frames"] > 0


def pull_cable(network: Network, host: Host) -> tuple[float, float]:
    """Seconds until the camera was missed, and from the cable's return to the first frame."""
    network.set_link("down")
    pulled = time.monotonic()
    lost = host.wait_for("lost")
    assert "did not answer" in lost["why"]
    time.sleep(max(pulled + PULL_SECONDS - time.monotonic(), 0))
    network.set_link("up")
    back = time.monotonic()
    first = host.wait_for("frame")
    return lost["at"] - pulled, first["at"] - back

"""A host with two cards in one network, each with a cable of its own: the camera is on the second.

The routing table leads to the first for every address there (aravis 242).
"""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from in_namespace import EXPOSURE
from namespaces import CAMERA, HOST, Host, Network, network, run

pytestmark = pytest.mark.netns
__all__ = ["network"]
SECOND_CARD = "10.77.0.3"


@pytest.fixture
def second_card(network: Network) -> Network:
    """The camera is behind eth1; eth0, with a dead end, has an address in the same network."""
    made = run(
        *("ip", "link", "add", "eth0", "netns", network.host, "type", "veth"),
        *("peer", "name", "end0", "netns", network.host),
    )
    if made.returncode:
        pytest.skip(f"no virtual Ethernet devices here: {made.stderr.strip()}")
    run("ip", "-n", network.host, "addr", "add", f"{HOST}/24", "dev", "eth0")
    for device in ("eth0", "end0"):
        run("ip", "-n", network.host, "link", "set", device, "up")
    network.join("eth1", CAMERA, SECOND_CARD)
    network.device = "eth1"
    route = run("ip", "-n", network.host, "-j", "route", "get", CAMERA).stdout
    assert json.loads(route)[0]["dev"] == "eth0", "the routing table is no help"
    return network


def grabbergui(network: Network, *arguments: str) -> subprocess.CompletedProcess[str]:
    every = ("env", "GRABBERGUI_INTERFACES=")
    return run("ip", "netns", "exec", network.host, *every, sys.executable, "-m", "grabbergui", *arguments)


def test_the_card_that_heard_the_camera_is_used_for_everything(second_card: Network) -> None:
    network = second_card
    network.start_camera("sim:?width=320&height=240&fps=50&serial=CARD2", CAMERA, "eth1", "--loss", "2%")
    found = json.loads(grabbergui(network, "list", "--json").stdout)
    assert [entry["interface"] for entry in found if entry["serial"] == "CARD2"] == ["eth1"], found
    for uri in (f"gige:{CAMERA}", "gige:CARD2"):
        host = Host(network, uri, interfaces="")
        host.wait_for("many")
        if uri == "gige:CARD2":  # found again on the same card
            network.set_link("down")
            host.wait_for("lost")
            network.set_link("up")
            host.wait_for("frame")
        reported = host.end()
        assert reported["exposure"] == EXPOSURE
        assert reported["frames"] > 0
        # One frame after the return may lose no packet.
        assert reported["packets_resent"] > 0 or uri == "gige:CARD2"


def test_the_card_is_named_when_nothing_answers(second_card: Network) -> None:
    refused = grabbergui(second_card, "features", f"gige:{CAMERA}")
    assert refused.returncode != 0
    assert "no GigE Vision camera answers at 10.77.0.1" in refused.stderr
    assert "eth0 (10.77.0.2)" in refused.stderr and "eth1 (10.77.0.3)" in refused.stderr
    found_none = grabbergui(second_card, "features", "gige:CARD9")
    assert "eth0 (10.77.0.2)" in found_none.stderr and "eth1 (10.77.0.3)" in found_none.stderr

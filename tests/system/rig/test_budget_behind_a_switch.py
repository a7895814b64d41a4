"""Six cameras behind a switch with a slow port and a small buffer, in network namespaces.

`GRABBERGUI_BUDGET_SECONDS=60` makes it long, `GRABBERGUI_BUDGET_PART=0.895` fills the line; see docs/rig.md
for what that gave. On a busy machine simulated cameras are late, so that less of the line is measured.
"""

from __future__ import annotations

import json
import os
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import namespaces
from grabbergui.rig import rig_file
from namespaces import CAMERA, HOST, Network, network, run

SUPPORT = Path(namespaces.__file__).parent
__all__ = ["network"]

pytestmark = pytest.mark.netns
SECONDS = os.environ.get("GRABBERGUI_BUDGET_SECONDS", "3")
ADDRESSES = [f"10.77.0.{number}" for number in range(11, 17)]
LINE = float(os.environ.get("GRABBERGUI_BUDGET_LINE", "2.5e6"))
"Bytes per second of the switch's port: 20 Mbit/s, as simulated cameras in Python pace their packets."
BUFFER = 64e3
FRAME_ON_WIRE = 320 * 240 + 53 * 74 + 168
PART = float(os.environ.get("GRABBERGUI_BUDGET_PART", "0.65"))
"What the cameras need of the line."
RATE = PART * LINE / FRAME_ON_WIRE / len(ADDRESSES)
"Sets per second."


def join_by_a_switch(network: Network) -> Any:
    """Join both namespaces by a switch in a third one; return its program."""
    between = f"{network.camera}s"
    assert not run("ip", "netns", "add", between).returncode
    network.programs._stack.callback(run, "ip", "netns", "del", between)
    for namespace, device, address in (
        (network.camera, "s0", f"{CAMERA}/24"),
        (network.host, "s1", f"{HOST}/24"),
    ):
        made = run(
            *("ip", "link", "add", device, "netns", between, "type", "veth"),
            *("peer", "name", "eth0", "netns", namespace),
        )
        if made.returncode:
            pytest.skip(f"no virtual Ethernet devices here: {made.stderr.strip()}")
        run("ip", "-n", between, "link", "set", device, "up")
        run("ip", "-n", namespace, "addr", "add", address, "dev", "eth0")
        run("ip", "-n", namespace, "link", "set", "eth0", "up")
        # Otherwise checksums are left to a card that is not there.
        if run("ip", "netns", "exec", namespace, "ethtool", "-K", "eth0", "tx", "off").returncode:
            pytest.skip("no ethtool here")
    switch = network.programs.start(
        between, str(SUPPORT / "finite_switch.py"), "s0", "s1", str(LINE), str(BUFFER)
    )
    assert switch.stdout is not None and switch.stdout.readline() == "ready\n"
    return switch


def command(network: Network, *words: str) -> Any:
    """Run a command of ours in the host's namespace; return the object that it printed."""
    program = network.programs.start(
        network.host, "-m", "grabbergui", "rig", *words, "--json", GRABBERGUI_INTERFACES="eth0"
    )
    assert program.stdout is not None
    return json.loads(program.stdout.readline())


def frames_and_lost(checked: dict[str, Any]) -> dict[str, tuple[int, int]]:
    return {
        name: (each["frames"], each["lost"] + each["incomplete"]) for name, each in checked["cameras"].items()
    }


def test_planned_cameras_lose_nothing_where_others_lose(
    network: Network, tmp_path: Path, record_property: pytest.RecordProperty
) -> None:
    switch = join_by_a_switch(network)
    for address in ADDRESSES:
        run("ip", "-n", network.camera, "addr", "add", f"{address}/24", "dev", "eth0")
    cameras = network.programs.start(
        network.camera,
        *(str(SUPPORT / "wired_cameras.py"), str(RATE), "320", "240", *ADDRESSES),
        GRABBERGUI_INTERFACES="eth0",
    )
    assert cameras.stdout is not None and cameras.stdout.readline()
    file = tmp_path / "six.yaml"
    sources = "".join(f"  c{n}: gige:{address}?resend=0\n" for n, address in enumerate(ADDRESSES))
    file.write_text(
        f"cameras:\n{sources}trigger: {{by: action, rate: {RATE:.4f}}}\n"
        f"link: {{rate: {2 * LINE:.0f}, share: 0.95, buffer: {BUFFER:.0f}}}\nwait: 2s\n"
    )
    unplanned = command(network, "check", str(file), "-t", SECONDS)
    measured = command(network, "budget", str(file), "--measure")["measured"]
    entry = rig_file.read(file)
    rig_file.write(file, replace(entry, link=replace(entry.link, rate=LINE)))
    planned = command(network, "budget", str(file), "--verify", "--apply", "-t", SECONDS)
    checked = command(network, "check", str(file), "-t", SECONDS)
    switch.stdin.close()
    reported = {
        "unplanned": frames_and_lost(unplanned),
        "measured": measured,
        "planned": planned,
        "checked": frames_and_lost(checked),
        "sets": checked["sets"],
        "switch": json.loads(switch.stdout.readline()),
    }
    print(json.dumps(reported), file=sys.stderr)
    record_property("budget", reported)
    assert sum(lost for _, lost in reported["unplanned"].values()) > 5
    assert 0.7 * LINE < measured["rate"] < 1.02 * LINE and measured["limited"]
    assert not planned["problems"] and all(each["lost"] == 0 for each in planned["verified"].values())
    assert rig_file.read(file).cameras["c0"].settings["GevSCPD"] > 1_000_000
    assert all(lost == 0 and frames for frames, lost in reported["checked"].values())

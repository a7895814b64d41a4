"""Six cameras with drifting clocks in one network namespace, their host in another, and a bad cable between.

`GRABBERGUI_RIG_SETS=10000` makes it long; see docs/rig.md for what that gave.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import pytest

import namespaces
from namespaces import CAMERA, HOST, Network, network, run

SUPPORT = Path(namespaces.__file__).parent
__all__ = ["network"]

pytestmark = pytest.mark.netns
SETS = int(os.environ.get("GRABBERGUI_RIG_SETS", "60"))
RATE = float(os.environ.get("GRABBERGUI_RIG_RATE", "15"))
ADDRESSES = [f"10.77.0.{number}" for number in range(11, 17)]
LOSS, DELAY_MS, JITTER_MS, REORDER = 0.01, 0.6, 0.5, 0.05


def test_no_set_is_mismatched_on_a_bad_cable(
    network: Network, tmp_path: Path, record_property: pytest.RecordProperty
) -> None:
    wire = network.programs.start(
        "",
        str(SUPPORT / "lossy_wire.py"),
        *(network.camera, "eth0", f"{CAMERA}/24", network.host, "eth0", f"{HOST}/24"),
        *map(str, (LOSS, DELAY_MS, JITTER_MS, REORDER)),
    )
    if wire.stdout is None or wire.stdout.readline() != "ready\n":
        pytest.skip("no tap devices here")
    for address in ADDRESSES:
        run("ip", "-n", network.camera, "addr", "add", f"{address}/24", "dev", "eth0")
    cameras = network.programs.start(
        network.camera,
        *(str(SUPPORT / "wired_cameras.py"), str(RATE), "64", "48", *ADDRESSES),
        GRABBERGUI_INTERFACES="eth0",
    )
    assert cameras.stdout is not None
    clocks = json.loads(cameras.stdout.readline())
    file = tmp_path / "six.yaml"
    # Lost packets are not sent again, so that frames are lost.
    sources = "".join(f"  c{n}: gige:{address}?resend=0\n" for n, address in enumerate(ADDRESSES))
    file.write_text(
        f"cameras:\n{sources}clock: fitted\ntrigger: {{by: line, leader: c0, rate: {RATE}}}\n"
        "deadline: 200ms\nwait: 2s\n"
    )
    host = network.programs.start(
        network.host,
        *(str(SUPPORT / "rig_host.py"), str(file), str(SETS), json.dumps(clocks)),
        GRABBERGUI_INTERFACES="eth0",
    )
    assert host.stdout is not None
    reported = json.loads(host.stdout.readline())
    print(json.dumps(reported), file=sys.stderr)
    record_property("rig", reported)
    assert reported["sets"] == SETS and reported["mismatched"] == 0
    assert reported["beyond_uncertainty"] == 0
    assert reported["counts"]["incomplete"] > 0, "this was no bad cable"
    whole = reported["counts"]["complete"] + reported["counts"]["late"]  # late on a busy machine
    assert whole >= SETS // 2

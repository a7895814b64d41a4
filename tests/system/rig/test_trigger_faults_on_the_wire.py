"""Faults of triggers of simulated cameras on the wire are named rightly, and healthy rigs not accused.

`GRABBERGUI_TRIGGER_TRIES=15` tries each fault so often; see docs/rig.md for what that gave.
"""

from __future__ import annotations

import os
import random
import time
from collections.abc import Iterator

import pytest

from grabbergui.driver.gige.gvcp import CommandCode
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige.server import GigeCamera
from grabbergui.rig import source
from grabbergui.rig.grabber import RigGrabber
from grabbergui.rig.rig_file import CameraEntry, RigEntry, TriggerEntry
from grabbergui.rig.trigger_diagnosis import TriggerCause
from patience import until

NET = f"127.90.{os.getpid() % 250 + 1}"
"Network of this test run alone: others may run at the same time."
TRIES = range(int(os.environ.get("GRABBERGUI_TRIGGER_TRIES", "1")))
MS = 1_000_000
PULSES = 14
EXPOSURE_US = 4000.0
Cameras = dict[str, GigeCamera]


@pytest.fixture(scope="module")
def cameras() -> Iterator[Cameras]:
    small = {reg.WIDTH: 64, reg.HEIGHT: 48, reg.EXPOSURE_TIME: EXPOSURE_US}
    started = {
        name: GigeCamera(f"{NET}.{number}", power_on=small, drift=drift)
        for number, (name, drift) in enumerate((("left", 40e-6), ("right", -40e-6)), 1)
    }
    started["left"].wire_to(started["right"])
    yield started
    for camera in started.values():
        camera.close()


@pytest.fixture
def rigs(cameras: Cameras) -> Iterator[list[RigGrabber]]:
    opened: list[RigGrabber] = []
    yield opened
    for rig in opened:
        rig.close()


def started(rigs: list[RigGrabber], cameras: Cameras, trigger: TriggerEntry, *names: str) -> RigGrabber:
    entry = RigEntry(
        {name: CameraEntry(f"gige:{cameras[name].address}") for name in names or cameras},
        clock="ptp" if trigger.by == "action" else "fitted",
        trigger=trigger,
    )
    rig = source.of_entry(entry)
    rigs.append(rig)
    rig.open()
    rig.start()
    return rig


def play(camera: GigeCamera, edges: list[tuple[int, bool]]) -> None:
    """Put a signal on a camera's input; edges have their time after the beginning, in ns."""
    begin = time.monotonic_ns() + 20 * MS
    for after, high in sorted(edges):
        time.sleep(max(0, begin + after - time.monotonic_ns()) / 1e9)
        camera.model.set_input(high, begin + after)


def edges_of(pulses: list[int], width: int = 2 * MS) -> list[tuple[int, bool]]:
    return [(at, True) for at in pulses] + [(at + width, False) for at in pulses]


def regular(chance: random.Random, period: int = 25 * MS) -> list[int]:
    return [round((number + chance.uniform(-0.01, 0.01)) * period) for number in range(PULSES)]


def signal(fault: str, chance: random.Random) -> list[tuple[int, bool]]:
    pulses = regular(chance)
    if fault == "missed":
        del pulses[chance.randrange(3, PULSES - 3)]
    elif fault == "double":
        pulses.insert(5, pulses[4] + chance.randint(5 * MS, 7 * MS))
    elif fault == "too fast":
        pulses = regular(chance, chance.randint(2 * MS, 3 * MS + MS // 2))
        return edges_of(pulses, MS // 2)
    edges = edges_of(pulses)
    if fault == "bouncing":
        for at in chance.sample(pulses, 4):
            edges += [(at + 60_000, False), (at + 130_000, True)]
    return edges


CAUSES = {
    "well": TriggerCause.NONE,
    "missed": TriggerCause.PULSES_MISSING,
    "double": TriggerCause.DOUBLE,
    "bouncing": TriggerCause.BOUNCING,
    "too fast": TriggerCause.TOO_FAST,
}


@pytest.mark.parametrize("fault", CAUSES)
def test_a_fault_of_a_signal_is_named(fault: str, cameras: Cameras, rigs: list[RigGrabber]) -> None:
    for seed in TRIES:
        rig = started(rigs, cameras, TriggerEntry("line"), "right")
        edges = signal(fault, random.Random(seed))
        play(cameras["right"], edges)
        count = sum(high for _, high in edges)
        until(lambda rig=rig, count=count: settled(rig, count))
        found = rig.trigger_findings()["right"]
        assert found.cause is CAUSES[fault], (seed, found, rig._watches["right"].evidence())
        rig.close()


def settled(rig: RigGrabber, count: int) -> bool:
    """Whether so many edges have arrived, and each has made its frame or was reported as missed."""
    evidence = rig._watches["right"].evidence()
    edges = len(evidence.rising or ())
    return edges >= count and len(evidence.frames) + len(evidence.missed) + evidence.lost >= edges


@pytest.mark.parametrize("inverted", [False, True], ids=["well", "wrong polarity"])
def test_a_leaders_polarity_is_watched(inverted: bool, cameras: Cameras, rigs: list[RigGrabber]) -> None:
    for _ in TRIES:
        rig = started(rigs, cameras, TriggerEntry("line", 15, leader="left", inverted=inverted))
        until(lambda rig=rig: rig.counts().sets >= 12)
        # The edges of a pulse can be distinguished once the clocks are known better than its width.
        until(lambda rig=rig: 0 < rig._watches["right"].evidence().clock_ns < EXPOSURE_US * 1000)
        wanted = TriggerCause.WRONG_EDGE if inverted else TriggerCause.NONE
        found = rig.trigger_findings()["right"]
        assert found.cause is wanted, (found, rig._watches["right"].evidence())
        rig.close()


@pytest.mark.parametrize("fault", ["well", "group mask", "lost"])
def test_a_fault_of_actions_is_named(
    fault: str, cameras: Cameras, rigs: list[RigGrabber], monkeypatch: pytest.MonkeyPatch
) -> None:
    for seed in TRIES:
        with monkeypatch.context() as patch:
            rig = started(rigs, cameras, TriggerEntry("action", 10))
            if fault == "group mask":
                rig.cameras["right"].write_feature("ActionGroupMask", 2)
            elif fault == "lost":
                control, chance = cameras["right"].control, random.Random(seed)
                receive = control.receive

                def lossy(datagram, sender, now, receive=receive, chance=chance):  # type: ignore[no-untyped-def]
                    is_action = int.from_bytes(datagram[2:4], "big") == CommandCode.ACTION
                    return [] if is_action and chance.random() < 0.3 else receive(datagram, sender, now)

                patch.setattr(control, "receive", lossy)
            until(lambda rig=rig: rig.triggers_sent >= 8)
            found = {name: each.cause for name, each in rig.trigger_findings().items()}
            wanted = {
                "well": TriggerCause.NONE,
                "group mask": TriggerCause.ACTION_KEYS,
                "lost": TriggerCause.ACTION_LOST,
            }[fault]
            assert found == {"left": TriggerCause.NONE, "right": wanted}, rig._watches["right"].evidence()
            rig.close()

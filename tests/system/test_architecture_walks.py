"""`docs/architecture.md` draws what happens: a packet, a value and a request enter each step in turn."""

from __future__ import annotations

import ast
import functools
import importlib
import os
import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from architecture_walks import ROOT, walks
from grabber_stage import stage
from grabbergui import sources
from grabbergui.core.grabber import FrameGrabber
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige.server import GigeCamera
from grabbergui.models.change_journal import ChangeJournal
from grabbergui.models.change_tracking import ChangeTrackingGrabber
from grabbergui.models.features.tree import FeatureTreeModel
from grabbergui.models.features.worker import FeatureWorker
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.rpc_client import RpcClient
from patience import PATIENCE

ADDRESS = f"127.96.{os.getpid() % 250 + 1}.1"
"Of this test run alone: others may run at the same time."
WINDOW = "ui"
"The package of a value's first steps, which tests of the window take by mouse and keyboard."


class Footprints:
    """Notes how the steps of a drawing are entered."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, steps: list[tuple[str, str, str]]) -> None:
        self.on = False
        self.entered: dict[str, int] = {}
        "Each step in the order of their first times, with its thread."
        self.nested: set[tuple[str, ...]] = set()
        "Steps within steps, on one thread."
        self._within = threading.local()
        for package, owner, method in steps:
            self._watch(monkeypatch, _class(package, owner), method)

    def _watch(self, monkeypatch: pytest.MonkeyPatch, owner: type, method: str) -> None:
        real: Callable[..., Any] = getattr(owner, method)
        step = f"{owner.__name__}.{method}"

        @functools.wraps(real)
        def entered(*arguments: Any, **options: Any) -> Any:
            outer = getattr(self._within, "steps", ())
            self._within.steps = (*outer, step)
            if self.on:
                self.entered.setdefault(step, threading.get_ident())
                self.nested.add(self._within.steps)
            try:
                return real(*arguments, **options)
            finally:
                self._within.steps = outer

        monkeypatch.setattr(owner, method, entered)


@functools.cache
def _class(package: str, name: str) -> type:
    """Return the class of a drawing's package."""
    for path in sorted((ROOT / "grabbergui" / package).rglob("*.py")):
        tree = ast.parse(path.read_text("utf-8"))
        if any(isinstance(node, ast.ClassDef) and node.name == name for node in tree.body):
            module = ".".join(path.relative_to(ROOT).with_suffix("").parts)
            return getattr(importlib.import_module(module), name)  # type: ignore[no-any-return]
    raise AssertionError(f"grabbergui/{package} has no class {name}")


def named(steps: list[tuple[str, str, str]]) -> list[str]:
    return [f"{owner}.{method}" for _, owner, method in steps]


@pytest.fixture
def camera() -> Iterator[FrameGrabber]:
    power_on = {reg.WIDTH: 640, reg.HEIGHT: 480, reg.FRAME_RATE: 50.0, reg.EXPOSURE_TIME: 2000.0}
    simulated = GigeCamera(ADDRESS, power_on=power_on)
    grabber = sources.create(f"gige:{ADDRESS}")
    yield grabber
    grabber.close()
    simulated.close()


def test_a_packet_takes_its_way_through_one_thread(
    camera: FrameGrabber, monkeypatch: pytest.MonkeyPatch
) -> None:
    steps = walks()["A packet"]
    instead = "InPlaceReader.receive"  # only of packets that the kernel joined
    drawn = [step for step in named(steps) if step != instead]
    way = Footprints(monkeypatch, steps)
    camera.open()
    queue = camera.open_queue()
    way.on = True
    camera.start()
    for _ in range(3):
        queue.get(PATIENCE)
    camera.stop()
    assert [step for step in way.entered if step != instead] == drawn
    assert len(set(way.entered.values())) == 1


def test_a_value_takes_its_way_through_the_worker(
    camera: FrameGrabber, monkeypatch: pytest.MonkeyPatch
) -> None:
    steps = [step for step in walks()["A slider's value"] if step[0] != WINDOW]
    way = Footprints(monkeypatch, steps)
    camera.open()
    worker = FeatureWorker("way")
    tree = FeatureTreeModel(ChangeTrackingGrabber(camera, ChangeJournal()), worker)
    changed = threading.Event()
    tree.feature_changed.connect(lambda feature: changed.set())
    way.on = True
    tree.write("Gain", 3.0)
    assert changed.wait(PATIENCE)
    assert worker.close(PATIENCE)
    asked, *worker_steps = named(steps)
    assert way.entered[asked] == threading.get_ident()
    assert tuple(worker_steps) in way.nested
    assert camera.feature("Gain").value == 3.0


def test_a_request_takes_its_way_through_its_connection(monkeypatch: pytest.MonkeyPatch) -> None:
    steps = walks()["A YARP request"]
    way = Footprints(monkeypatch, steps)
    with stage() as scene, scene.share(), RpcClient("/grabber/rpc", scene.names) as rpc:
        way.on = True
        rpc.call(Bottle.from_text("[fgc] [set] [feat] 1 0.5"))
    begin, *others = named(steps)
    message = [step for step in others if step.endswith(".next_event")]
    answer = [step for step in others if step not in message]
    assert {(begin, *message), (begin, *answer)} <= way.nested

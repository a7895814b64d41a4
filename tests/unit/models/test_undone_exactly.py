"""Whatever was changed, undoing all of it brings back the start."""

import os
import random

import pytest

from grabbergui import sources
from grabbergui.models.settings.feature_set import capture
from grabbergui.models.undo_steps import MOST_STEPS
from operator_bench import UNDO, Bench
from random_settings import any_write, differences

ROUNDS = int(os.environ.get("GRABBERGUI_UNDO_ROUNDS", "2"))
"Random histories that are undone."
CHANGES = int(os.environ.get("GRABBERGUI_UNDO_CHANGES", "60"))
"In each of them; at most as many as are remembered."


@pytest.fixture
def sim():
    camera = sources.create("sim:")
    camera.open()
    yield Bench(camera)
    camera.close()


def test_a_height_comes_back_with_the_binning_that_cut_it(sim):
    before = {name: sim.value(name) for name in ("BinningVertical", "Height", "OffsetY")}
    sim.write("BinningVertical", 4)
    assert sim.value("Height") < before["Height"]

    assert sim.revert(UNDO) == []

    assert {name: sim.value(name) for name in before} == before
    assert sim.journal.next_text(UNDO) == ""


def test_consequences_are_logged_as_the_cameras_and_not_named_by_the_step(sim):
    sim.write("BinningVertical", 4)
    assert sim.journal.next_text(UNDO) == "BinningVertical 1 → 4"
    assert [(change.key.name, change.origin.value) for change in sim.journal.changes] == [
        ("BinningVertical", "operator"),
        ("Height", "camera"),
        ("OffsetY", "camera"),
    ]


def test_a_drag_with_consequences_is_one_step(sim):
    before = capture(sim.grabber)
    for value in (2, 3, 4):
        sim.write("BinningVertical", value, wait=0.05)
    assert sim.journal.next_text(UNDO) == "BinningVertical 1 → 4"
    assert sim.revert(UNDO) == []
    assert differences(before, capture(sim.grabber)) == []


@pytest.mark.parametrize("seed", range(ROUNDS))
def test_random_changes_undone_are_the_start(sim, seed):
    print(f"seed {seed}")
    chance = random.Random(seed)
    if seed % 2:
        sim.grabber.start()
    before = capture(sim.grabber)
    for _ in range(min(CHANGES, MOST_STEPS)):
        any_write(sim.tracked_grabber, chance)
        sim.now += 10.0
    while sim.journal.next_text(UNDO):
        sim.revert(UNDO)  # what an automatic mode hinders at first comes back when that mode is undone

    assert sim.journal.owed(UNDO) == {}
    assert differences(before, capture(sim.grabber)) == []

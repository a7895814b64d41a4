"""The fuzz targets run on their seeds, on former crashes, and on small changes to both.

The search itself is `make fuzz`; this keeps the targets in step with the parsers.
"""

from __future__ import annotations

import importlib
import logging
import random
from collections.abc import Iterator
from pathlib import Path

import pytest

from every_case import every_case

pytest.importorskip("fuzz", reason="fuzz/ is found from the checkout: python -m pytest")

from fuzz.__main__ import names

FOUND = sorted(
    path for path in (Path(__file__).parents[1] / "data" / "fuzz").iterdir() if path.suffix != ".md"
)
MOST_SEEDS = 60
CHANGES = 5


@pytest.fixture(autouse=True)
def quiet() -> Iterator[None]:
    logging.disable()
    yield
    logging.disable(logging.NOTSET)


@every_case("name", names())
def test_seeds_and_small_changes_go_through(name: str) -> None:
    target = importlib.import_module(f"fuzz.{name}")
    seeds = target.seeds()
    chance = random.Random(name)
    assert seeds
    for seed in chance.sample(seeds, min(MOST_SEEDS, len(seeds))):
        target.one_input(seed)
        for _ in range(CHANGES):
            target.one_input(changed(seed, chance))


@pytest.mark.parametrize("path", FOUND, ids=lambda path: path.name)
def test_what_was_found_stays_mended(path: Path) -> None:
    target = importlib.import_module(f"fuzz.{path.name.partition('-')[0]}")
    finding = None
    try:
        target.one_input(path.read_bytes())
    except Exception as error:
        finding = error
    assert finding is None, f"{path.name} is a finding again: {finding!r}"


def changed(data: bytes, chance: random.Random) -> bytes:
    """Change some bytes, or truncate the data."""
    content = bytearray(data)
    for _ in range(chance.randint(1, 4)):
        other = chance.choice((0, 1, 0x7F, 0x80, 0xFF, chance.randrange(256)))
        content[chance.randrange(len(content))] = other
    return bytes(content[: chance.randint(1, len(content))] if chance.random() < 0.3 else content)

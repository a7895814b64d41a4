"""Real cameras' descriptions over registers of zeros, of ones, or of noise: every feature is sound."""

import os
import random
from pathlib import Path

import pytest

from fakes import XmlDevice
from grabbergui.driver.genapi.node_map import CameraNodeMap
from soundness import assert_sound

FOLDER = Path(
    os.environ.get("GRABBERGUI_GENICAM_XML", Path(__file__).parents[4].parent / "shared" / "genicam-xml")
)
DESCRIPTIONS = sorted(FOLDER.glob("*.xml"))
NONE = [pytest.param(None, marks=pytest.mark.skip("no vendors' XML here; set GRABBERGUI_GENICAM_XML"))]


class Filled(XmlDevice):
    """A device whose every byte is what `byte` makes of its address."""

    def __init__(self, xml, byte):
        super().__init__(xml)
        self._byte = byte

    def read(self, address, length):
        return bytes(self._byte(address + offset) for offset in range(length))


def noise(address: int) -> int:
    return random.Random(address).randrange(256)


@pytest.mark.parametrize("byte", [lambda address: 0, lambda address: 0xFF, noise], ids=["0", "255", "noise"])
@pytest.mark.parametrize("path", DESCRIPTIONS or NONE, ids=lambda path: path.stem if path else "none")
def test_every_feature_is_sound_whatever_the_registers_hold(path, byte):
    nodes = CameraNodeMap(Filled(path.read_bytes(), byte), path.read_bytes(), lambda names: None)
    descriptions = list(nodes.root.descriptions())
    assert descriptions
    for description in descriptions:
        assert_sound(nodes.feature(description.name))
    nodes.close()

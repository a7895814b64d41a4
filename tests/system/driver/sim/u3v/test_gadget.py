"""The gadget's folder in configfs, shared by programs; transfers are tested in a virtual machine."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from grabbergui.core.errors import SourceUnavailableError
from grabbergui.driver.sim.u3v import gadget
from grabbergui.driver.sim.u3v.device import SimulatedU3vDevice
from grabbergui.driver.sim.u3v.gadget import Gadget

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="gadgets are of Linux")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The gadget of a program that was started earlier."""
    controllers, gadgets = tmp_path / "udc", tmp_path / "usb_gadget"
    (controllers / "fe980000.usb").mkdir(parents=True)
    monkeypatch.setattr(gadget, "_CONTROLLERS", controllers)
    monkeypatch.setattr(gadget, "_CONFIGFS", gadgets)
    monkeypatch.setattr(gadget.signal, "signal", lambda *_: None)
    (gadgets / gadget._NAME).mkdir(parents=True)
    return gadgets / gadget._NAME


def test_a_second_camera_leaves_the_first_plugged_in(folder: Path) -> None:
    (folder / "UDC").write_text("fe980000.usb\n")
    with (
        pytest.raises(SourceUnavailableError, match=r"another simulated camera .* fe980000\.usb"),
        Gadget(SimulatedU3vDevice()),
    ):
        pass
    assert (folder / "UDC").read_text() == "fe980000.usb\n"


def test_what_a_killed_program_left_is_removed(folder: Path) -> None:
    # A plain folder lacks what configfs makes in it: the attempt goes on until then.
    with (
        pytest.raises(SourceUnavailableError, match="No such file"),
        Gadget(SimulatedU3vDevice()),
    ):
        pass

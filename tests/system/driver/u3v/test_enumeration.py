"""Which USB3 Vision camera a name leads to, and the errors if none can be opened."""

from __future__ import annotations

from grabbergui.driver.u3v import device
from patience import attempts


def test_looking_for_cameras_is_quick_and_silent_without_any() -> None:
    for watch in attempts(2.0):
        with watch:
            found = device.discover(1.0)
    assert all(info.bus == "USB3 Vision" for info in found)

"""Makes a camera in this process unreachable for a block, as if its cable were pulled."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from grabbergui.core.errors import DeviceLostError
from grabbergui.core.grabber import Access
from grabbergui.driver.device_grabber import DeviceGrabber


@contextmanager
def away(camera: DeviceGrabber, reason: str) -> Iterator[None]:
    """Make the camera fail to answer or open within the block, and report its loss for this reason."""

    def refuse(access: Access) -> Access:
        raise DeviceLostError("still gone")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(camera.device, "open", refuse)
        camera.device.close()
        camera.device.on_lost(reason)
        yield

"""A camera in this process that is away until the end of a block, as with its cable out."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from grabbergui.core.errors import DeviceLostError
from grabbergui.core.grabber import Access
from grabbergui.driver.camera import Camera


@contextmanager
def away(camera: Camera, reason: str) -> Iterator[None]:
    """Neither answer nor open again within the block; the loss is reported for this reason."""

    def refuse(access: Access) -> Access:
        raise DeviceLostError("still gone")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(camera.device, "open", refuse)
        camera.device.close()
        camera.device.on_lost(reason)
        yield

"""A camera is polled only for those who listen."""

import time


def test_nothing_is_polled_while_nobody_listens(camera, monkeypatch):
    camera.write_feature("ExposureAuto", "Continuous")
    reads = []
    read = camera.device.read
    monkeypatch.setattr(camera.device, "read", lambda *arguments: reads.append(arguments) or read(*arguments))

    time.sleep(0.5)

    assert reads == []

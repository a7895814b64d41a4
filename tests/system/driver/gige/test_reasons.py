"""One diagnosis of a camera that sends nothing: firewall, NAT, two cards, an unknown payload."""

from __future__ import annotations

import os
from contextlib import closing

import pytest

from grabbergui import sources
from grabbergui.cli import main
from grabbergui.core.errors import FrameTimeoutError
from grabbergui.driver.gige.device import GigeDevice
from grabbergui.driver.sim.gige.server import GigeCamera
from patience import until

ADDRESS = f"127.16.{os.getpid() % 250 + 1}.1"


def test_a_stream_that_is_cut_off_reports_it_everywhere(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The camera answers, but its stream goes elsewhere, as through a NAT."""
    monkeypatch.setattr("grabbergui.driver.gige.device._host_seen_by", lambda memory: "10.9.9.9")
    monkeypatch.setattr(GigeCamera, "_configure_stream", lambda camera: None)
    with closing(GigeCamera(ADDRESS)):
        assert main(["grab", f"gige:{ADDRESS}", "-n", "1", "--timeout", "0.3"]) != 0
        assert "the camera sees this computer at 10.9.9.9" in capsys.readouterr().err
        import grabbergui

        with grabbergui.open(f"gige:{ADDRESS}") as camera, pytest.raises(FrameTimeoutError, match="NAT"):
            camera.grab(timeout=0.3)


def test_a_device_that_streams_has_no_reason() -> None:
    with closing(GigeCamera(ADDRESS)), closing(sources.create(f"gige:{ADDRESS}")) as grabber:
        grabber.open()
        queue = grabber.open_queue(1)
        grabber.start()
        until(lambda: grabber.statistics().frames, "a frame")
        assert grabber.silence() == "" and isinstance(grabber.device, GigeDevice)
        queue.close()

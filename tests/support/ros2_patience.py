"""Times of our ROS 2 client where others have the cores: what is there is found in the end."""

from __future__ import annotations

import pytest

TIMES = {
    "client.DISCOVERY_TIMEOUT": 20.0,
    "client_link.SERVICE_TIMEOUT": 20.0,
    "client_link.SETTLED": 5.0,
    "client_link.FIRST_ANSWER": 20.0,
    "client.OVERDUE": 5.0,
}
"Seconds; a server may be silent for longer than one that was killed is waited for."


def be_patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Give discovery, services and a silent server these times for one test."""
    for name, seconds in TIMES.items():
        monkeypatch.setattr(f"grabbergui.net.ros2.{name}", seconds)

"""What a robot waits for on a busy machine."""

import pytest

from servo_limits import patient_config


@pytest.fixture
def config():
    """Return the configuration of a run in real time."""
    return patient_config()

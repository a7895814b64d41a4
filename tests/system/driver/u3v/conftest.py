"""A simulated camera on a bus within the process."""

from plugged_camera import plug_in  # noqa: F401

"""A simulated camera."""

from driver_camera import camera  # noqa: F401

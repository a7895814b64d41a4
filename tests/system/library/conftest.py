"""A small, fast simulated camera."""

from library_camera import camera  # noqa: F401

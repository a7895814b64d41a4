"""Feature panels without the window."""

from panels import make_panel  # noqa: F401

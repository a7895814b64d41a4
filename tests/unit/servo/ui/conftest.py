"""The servoing window, alone."""

from servoing_window import window  # noqa: F401

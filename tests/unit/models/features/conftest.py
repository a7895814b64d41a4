"""Feature trees on scripted grabbers."""

from tree_stages import stage  # noqa: F401

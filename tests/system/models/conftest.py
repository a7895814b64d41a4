"""An operator on a made-up camera, and one on the simulated camera."""

from operators import operator, sim  # noqa: F401

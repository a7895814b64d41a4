"""The pixel formats that tests go through one by one."""

from grabbergui.core.pfnc import FORMATS

CONVERTIBLE = tuple(pixel_format for pixel_format in FORMATS if pixel_format.convertible)
"""Those that can be shown."""

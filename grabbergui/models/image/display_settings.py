"""How an image is displayed: levels, clipping marks, orientation."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

from grabbergui.core.calibration import FrameCalibration
from grabbergui.core.coord3d import Scan3d
from grabbergui.core.frame import Frame
from grabbergui.models.image.orientation import Orientation
from grabbergui.models.image.quantities import (
    Levels,
    PolarisedView,
    Quantity,
    quantity_of,
)


@dataclass(frozen=True)
class Appearance:
    """Levels and colours of one component."""

    levels: Levels = field(default_factory=Levels)
    colour_map: str = ""
    "One of COLOUR_MAPS; empty for grey."
    polarised: PolarisedView = PolarisedView.MOSAIC


@dataclass(frozen=True)
class DisplaySettings:
    """Display settings of the image, which change neither the camera nor saved frames."""

    levels: Levels = field(default_factory=Levels)
    colour_map: str = ""
    "One of COLOUR_MAPS; empty for grey."
    show_clipping: bool = False
    orientation: Orientation = field(default_factory=Orientation)
    component: str = ""
    "The label of the shown component; empty for the frame's own image."
    appearances: Mapping[str, Appearance] = field(default_factory=dict)
    "Appearances of the other components, by label."
    side_by_side: bool = False
    "Whether all components of a frame are shown at once."
    scan: Scan3d = field(default_factory=Scan3d)
    "The camera's description of its coordinates."
    polarised: PolarisedView = PolarisedView.MOSAIC
    calibration: Callable[[Frame], FrameCalibration | None] | None = None
    """Returns the calibration that undistorts a frame; raises UsageError if it does not fit that frame.
    Called by the display thread, as it may ask the camera. None shows frames with their distortion."""

    def quantity(self, frame: Frame) -> Quantity | None:
        """Return the quantity that a frame measures; None for light. Raises PixelFormatError."""
        return quantity_of(frame, self.scan, self.polarised, self.levels, self.colour_map)

    def choosing(self, label: str, before: str) -> DisplaySettings:
        """Return the settings that show another component with its last appearance.

        `before` is the label of the component shown so far.
        """
        own = Appearance(self.levels, self.colour_map, self.polarised)
        appearances = {**self.appearances, before: own}
        appearances.pop(label, None)
        return replace(self.of_other(label), appearances=appearances)

    def of_other(self, label: str) -> DisplaySettings:
        """Return the settings of a component that is shown beside the chosen one."""
        appearance = self.appearances.get(label, Appearance())
        return replace(
            self,
            component=label,
            levels=appearance.levels,
            colour_map=appearance.colour_map,
            polarised=appearance.polarised,
        )


def with_levels(settings: DisplaySettings, black: float, white: float) -> DisplaySettings:
    """Return the settings with other levels, limited to the range and kept apart."""
    black = min(max(black, 0.0), 0.999)
    white = min(max(white, black + 0.001), 1.0)
    return replace(settings, levels=Levels(black, white))

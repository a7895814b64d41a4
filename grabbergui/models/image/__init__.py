"""The image to show: its component, viewport and rendering, quantities in false colour, points."""

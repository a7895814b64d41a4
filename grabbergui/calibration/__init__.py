"""Calibrating cameras: boards and markers, the fit and its file, and where a camera sits on a robot."""

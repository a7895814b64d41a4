"""Calibrating cameras: boards, their views, and the camera_info files of the result."""

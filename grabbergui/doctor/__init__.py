"""Checks for the usual problems between a camera and the window, with their remedies."""

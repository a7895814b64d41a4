"""The image to show: history, viewport, rendering."""

"""Measuring in the image: lines, regions, levels of each channel."""

"""Cameras: one grabber over any transport, and the transports."""

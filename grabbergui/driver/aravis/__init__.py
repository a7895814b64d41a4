"""Aravis, the C library, as a transport: the reference to compare with, and its quirks for odd hardware."""

"""Aravis, a C library, as a transport: a reference for comparison, with workarounds for unusual cameras."""

"""Measurements, not tests: `python -m benchmarks [NAME …]` prints figures of this machine."""

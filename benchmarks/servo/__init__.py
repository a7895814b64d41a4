"""Measurements of the guest `servo`: motion, limits, latency, faults and stops of a robot."""

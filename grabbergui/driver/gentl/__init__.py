"""Cameras of any vendor's GenTL producer (`.cti`), through `genicam.gentl`.

The binding holds the GIL while a producer runs, so no call here may wait inside a producer: events are
polled.
"""

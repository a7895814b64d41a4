"""Cameras of any vendor's GenTL producer (`.cti`), through `genicam.gentl`.

The binding keeps the GIL while a producer works, so nothing here lets a producer wait: events are looked
for, never waited for.
"""

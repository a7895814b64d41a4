"""GigE Vision.

`bootstrap`, `gvcp`, `gvcp_messages` and `gvsp` are the registers and codecs that a host and the simulated
camera share. The host's side: `discovery` finds cameras and gives them addresses, `control` reads and writes
one, `stream` receives its frames, `device` puts these together as a `Device`.
"""

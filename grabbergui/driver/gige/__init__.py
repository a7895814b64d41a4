"""GigE Vision.

`bootstrap`, `gvcp`, `gvcp_messages` and `gvsp` are the registers and codecs that a host and the simulated
camera share. The host's side: `discovery` finds cameras, `address_commands` gives them addresses;
`control_channel` and `control_link` read and write one, `message_channel` receives its events, `stream` its
frames; `device` puts these together as a `Device`.
"""

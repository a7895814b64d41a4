"""GigE Vision.

`bootstrap`, `gvcp`, `gvcp_messages` and `gvsp` are the registers and codecs that the host and the simulated
camera share. On the host, `discovery` finds cameras and `address_commands` gives them addresses;
`control_channel` and `control_link` read and write registers, `message_channel` receives events, `stream`
receives frames; `device` combines these into a `Device`.
"""

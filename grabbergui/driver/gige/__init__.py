"""GigE Vision.

`bootstrap`, `gvcp`, `gvcp_messages`, `identity` and `gvsp` are the registers and codecs that the host and the
simulated camera share. On the host, `discovery` finds cameras and `address_commands` gives them addresses;
`control_channel`, `control_link` and `device_memory` access registers, `message_channel` receives events,
`stream` receives frames; `device` combines these into a `Device`.
"""

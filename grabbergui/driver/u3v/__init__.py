"""USB3 Vision over libusb.

`enumeration` finds cameras. `gencp`, `bootstrap` and `stream_protocol` are codecs; `gencp.ControlChannel` and
`block_assembler` are sans-I/O protocols; `usb` (transfers and registers), `transfer_queues` and `threads`
do the I/O; `device` combines them into a `Device`.
"""

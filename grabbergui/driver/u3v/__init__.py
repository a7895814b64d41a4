"""USB3 Vision over libusb.

`enumeration` finds cameras. `gencp`, `bootstrap` and `stream_protocol` are codecs; the channel in `gencp`,
and `block_assembler`, are protocols without I/O; `usb` (transfers and registers), `transfer_queues` and
`threads` move bytes; `device` joins them.
"""

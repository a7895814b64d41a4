"""USB3 Vision over libusb.

`enumeration` finds cameras. `gencp`, `bootstrap` and `stream_protocol` are codecs; `control_channel` and
`block_assembler` are sans-I/O protocols. The I/O is in `usb` (transfers), `register_access`,
`transfer_queue` with `libusb_queue`, and the threads of `stream_receiver` and `watcher`; `device` combines
them into a `Device`.
"""

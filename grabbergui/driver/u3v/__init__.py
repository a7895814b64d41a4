"""USB3 Vision over libusb.

`gencp`, `bootstrap` and `stream_protocol` are codecs; the channel in `gencp`, and `block_assembler`, are
protocols without I/O; `usb`, `register_access`, `transfer_queues`, `libusb_queue`, `stream_receiver` and
`watcher` move bytes; `device` joins them.
"""

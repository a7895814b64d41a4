"""USB3 Vision over libusb.

`gencp`, `bootstrap` and `stream_protocol` are codecs; `control_channel` and `block_assembler` decide without
I/O; `usb`, `register_access`, `transfer_queue`, `stream_receiver` and `event_receiver` move bytes; `device`
joins them.
"""

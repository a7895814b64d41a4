"""USB3 Vision over libusb.

`gencp`, `bootstrap` and `stream_protocol` are codecs; `control_channel` and `block_assembler` decide without
I/O; `usb`, `register_access`, the transfer queues, `stream_receiver` and `watcher` move bytes; `device`
joins them.
"""

"""Frame grabbers, features and frames: the types and functions that all other packages use.

Nothing here opens a socket or imports Qt. Only `frame_queue.FrameSink` and the compiler of `compiled` start a
thread.
"""

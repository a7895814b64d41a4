"""Frame grabbers, features and frames: the types and functions that all other packages use.

Nothing here opens a socket or imports Qt. Only `frame_queue.FrameSink`, `scan3d` and the compiler of
`compiled_loops` start threads, and `scheduling` a short-lived one.
"""

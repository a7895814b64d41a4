"""Several cameras as one instrument: one clock, one trigger, matched sets of frames, one plan for the link.

Four modules decide without I/O or a clock of their own: `clock_fit`, `frame_sets`, `link_budget` and
`trigger_diagnosis`. `rig_file` reads and writes a rig's file; the others join the decisions to open
`FrameGrabber`s.
"""

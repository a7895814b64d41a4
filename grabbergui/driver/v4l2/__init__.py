"""Webcams and other Video4Linux2 devices as GenICam devices: `v4l2:`.

`video` calls the kernel, `description` makes a GenICam description of the driver's controls and formats, and
`device` maps the registers of that description to the kernel's calls. So all functions for GenICam cameras
work with webcams.
"""

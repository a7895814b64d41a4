"""Webcams and whatever else Linux drives by Video4Linux2, as a GenICam device: `v4l2:`.

`video` talks to the kernel, `description` turns its controls and formats into a GenICam description, and
`device` maps the registers of that description to the kernel's calls. So everything that works with a GenICam
camera works with a webcam.
"""

"""The ground floor: what a frame grabber, a feature and a frame are.

Everything above (driver, net, models, ui) speaks in these words. Nothing here opens a socket, starts
a thread or imports Qt.
"""

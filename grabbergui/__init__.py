"""Tune GenICam cameras live, and share them on YARP and ROS 2 networks."""

__version__ = "0.1.0"

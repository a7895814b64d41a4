"""Grabbers on networks: YARP, ROS 2, and what both share."""

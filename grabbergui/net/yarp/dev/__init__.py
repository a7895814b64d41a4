"""YARP's frame grabber devices: the RPC of both dialects, and the feature tree as an extension."""

"""YARP's frame grabber devices: the RPC of both dialects, and the whole feature tree beside it."""

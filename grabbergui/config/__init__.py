"""Configuration files, as YARP's ResourceFinder finds and reads them."""

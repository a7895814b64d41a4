"""Configuration: YARP's `.ini` files, the options of `grabbergui serve`, and whose requests are answered."""

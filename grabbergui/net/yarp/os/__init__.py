"""YARP's ports: Bottles, names, carriers, connections."""

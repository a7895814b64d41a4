"""The host's network interfaces, and the cameras on them."""

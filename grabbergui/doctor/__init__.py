"""What usually goes wrong between a camera and a window, and how to mend it."""

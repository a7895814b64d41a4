"""The simulated camera on USB: over USB/IP, as a USB gadget, or inside this process."""

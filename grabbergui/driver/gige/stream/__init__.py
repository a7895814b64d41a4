"""The stream channel of one camera: from packets at a socket to frames."""

"""The control channel of one camera: commands, heartbeat, memory, events, description."""

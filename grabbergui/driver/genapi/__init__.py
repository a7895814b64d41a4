"""GenApi: the camera's own description turned into features, by the EMVA's reference implementation."""

"""Simulated cameras made of a camera's report: `twin:` sources, and the same on the network."""

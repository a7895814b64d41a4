"""Robots: kinematic models, and the networks that reach their controllers."""

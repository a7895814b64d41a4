"""Adds parts to the program's environment and to the user's desktop, and removes them again."""

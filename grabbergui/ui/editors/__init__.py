"""Editors of one feature, made from its metadata."""

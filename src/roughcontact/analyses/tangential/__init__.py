"""Stick, slip and fretting."""

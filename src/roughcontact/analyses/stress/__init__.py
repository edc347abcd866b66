"""Stress below the surface of a contact."""

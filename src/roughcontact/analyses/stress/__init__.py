"""Stress below the surface."""

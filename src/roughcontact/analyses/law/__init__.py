"""Pressure over separation of an interface."""

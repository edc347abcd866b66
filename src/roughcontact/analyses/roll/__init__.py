"""Repeated passes over a yielding body."""

"""Repeated passes of a counter-body over a yielding body."""

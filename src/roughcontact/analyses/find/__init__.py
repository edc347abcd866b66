"""The load that gives a result."""

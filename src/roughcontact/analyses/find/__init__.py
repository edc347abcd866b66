"""Search for the load that gives a requested result."""

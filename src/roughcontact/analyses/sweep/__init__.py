"""Load curves: contact under ascending loads."""

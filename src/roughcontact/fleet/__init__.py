"""Many contacts."""

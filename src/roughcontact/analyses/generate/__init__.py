"""Generated surfaces."""

"""Groups of maps, and samples of one."""

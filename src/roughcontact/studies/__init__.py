"""Many contacts: load curve, history, search, comparison, resolution, sampling, uncertainty."""

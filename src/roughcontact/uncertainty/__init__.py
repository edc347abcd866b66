"""Uncertainty of a contact: grids, filters, instruments, intervals."""

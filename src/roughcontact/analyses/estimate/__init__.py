"""Estimate of a contact by formulas."""

"""Electrical and thermal resistance of a contact."""

"""Leakage of liquids and gases through a contact."""

"""Leakage of liquids and gases."""

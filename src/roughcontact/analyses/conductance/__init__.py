"""Electrical and thermal resistance."""

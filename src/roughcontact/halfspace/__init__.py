"""Elastic half-space: operators and stresses on arrays."""

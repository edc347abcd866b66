"""Solvers of bounded contact problems, on arrays."""

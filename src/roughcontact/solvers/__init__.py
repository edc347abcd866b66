"""Solvers of bounded contact problems and of flow through a network, on arrays."""

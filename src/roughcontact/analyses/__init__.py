"""Analyses of contacts: one folder for each command."""

"""Analyses of contacts, one folder per command."""

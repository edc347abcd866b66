"""Wear: how a finish runs in."""

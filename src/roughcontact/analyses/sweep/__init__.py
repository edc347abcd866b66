"""Contacts under rising loads."""

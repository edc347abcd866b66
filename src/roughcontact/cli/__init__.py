"""Command line of roughcontact."""

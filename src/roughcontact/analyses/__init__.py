"""What is computed of contacts: one folder for each command."""

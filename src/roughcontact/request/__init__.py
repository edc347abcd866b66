"""One run of the program, specified by text options."""

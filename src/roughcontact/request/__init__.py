"""One run of the program, asked for in words."""

"""What the package needs and no reader has to know: files, memory, processes, checks."""

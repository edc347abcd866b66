"""Tools of the package: files, memory, processes, arguments."""

"""Applications: command line, Python interface and browser."""

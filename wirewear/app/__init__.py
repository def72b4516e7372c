"""The applications: command line, Python and browser."""

"""Python interface to runs, studies and records."""

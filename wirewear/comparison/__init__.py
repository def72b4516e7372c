"""Comparison of simulation and experiment in numbers: loops at equal phase, registered scars, and maps of tests."""

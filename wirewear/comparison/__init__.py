"""Simulation beside experiment in numbers: loops on one phase, scars registered, tests on maps."""

"""Simulators by others (tier T3): fretting tests from the literature's equations, each with numerics of its own.

`half_space` and `layers` are for scoring alone: no development batch draws them. `foundation` and `strips` may be
looked at. No simulator shares code with the program; drive, instruments and loggers (`rig`, `logger`) are theirs too.
"""

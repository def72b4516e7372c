"""Runs, studies and records to work with from Python."""

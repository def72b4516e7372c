"""Readers of a laboratory's files: one file a kind, all of them in `registry`."""

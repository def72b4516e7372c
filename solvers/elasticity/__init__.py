"""Elastic bodies in contact: condensation to a patch, compliance, placement in the world, and coupling by mortars."""

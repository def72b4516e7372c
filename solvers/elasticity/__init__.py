"""Elastic bodies as a contact sees them: condensation, compliance, placement, and their coupling by mortars."""

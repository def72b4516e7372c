"""Elasticity, frictional contact with finite sliding, wear and cycle jumps."""

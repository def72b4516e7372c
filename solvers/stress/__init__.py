"""Stress in bodies under the forces of a contact, and between the nodes of its surface."""

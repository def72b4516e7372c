"""A simulated run: its plan, its problem, its cycles, and what it leaves behind."""

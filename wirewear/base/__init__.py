"""Base of all other packages: errors, quantities, files, the engine for many tasks, the frame of pages."""

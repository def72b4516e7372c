"""The ground that all rooms stand on: errors, quantities, files, the engine for many tasks, the frame of pages."""

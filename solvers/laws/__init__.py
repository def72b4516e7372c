"""Laws of friction, wear and layers, and what they may know of a place."""

"""Pages that need no other file, and what a notebook shows: one frame for all of them."""

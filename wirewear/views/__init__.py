"""Output for readers: pages, tables, pictures and sentences of runs, loops, comparisons and diagnoses."""

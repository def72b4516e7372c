"""What readers see: pages, tables, pictures and sentences of runs, loops, comparisons and diagnoses."""

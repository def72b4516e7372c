"""What is observed of a record: loops read, and the list of observables, measured and computed."""

"""What records are made of: nominal tests, nuisances, causes and their sizes, and the forward model of each tier."""

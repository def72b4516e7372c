"""What records are made of: nominal tests, nuisances, sizes of effects of the library, and a forward model a tier."""

"""The fast forward model: loops and wear under any circumstances, on the wear states of one nominal run."""

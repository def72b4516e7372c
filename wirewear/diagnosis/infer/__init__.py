"""From observables to causes: covariance, fits, evidence, classes, and how far the gap shrinks."""

"""Names of positions in a cycle, which commands offer before anything that computes is loaded."""

#: Names of positions: mid-stroke and ends of the stroke, and just after the reversals there.
POSITIONS = ("mid-forward", "end-forward", "after-end-forward", "mid-back", "end-back", "after-end-back")

"""Both branches of a loop, freed from free play, each with its fitted micro-slip.

A shelf is a stretch of a branch at nearly constant force about zero, along which the holder floats in its free play. A
fitted branch is a branch with the fit of its micro-slip and plateau.
"""

from dataclasses import dataclass

from wirewear.loops.branches import Branch, fit_micro_slip, settled, slides_visibly, split_branches
from wirewear.loops.cleaning import CleanLoop
from wirewear.loops.energy import balance, mean_force
from wirewear.loops.figures import Measured
from wirewear.loops.free_play import Shelf, play_of, shelves_of, without_shelf
from wirewear.loops.stick_slip import FittedBranch


@dataclass(frozen=True)
class BranchFits:
    """Forward and backward branch, each with its fit; the stroke in µm; and the shelves (forward, backward) of free
    play, None if there are none. Where there are, the branches are those that a rig without play would give.
    """

    forward: FittedBranch
    backward: FittedBranch
    length_um: float
    shelves: tuple[Shelf, Shelf] | None

    @property
    def both(self) -> tuple[FittedBranch, FittedBranch]:
        return self.forward, self.backward

    @property
    def slide(self) -> bool:
        """True if both branches have a plateau with at least three samples."""
        return slides_visibly(self.forward) and slides_visibly(self.backward)

    @property
    def misfit(self) -> float:
        return sum(slip.misfit for _, slip in self.both)

    @property
    def free_play(self) -> Measured | None:
        """Free play of the holder in µm; None where the loop has no shelves."""
        return None if self.shelves is None else play_of(self.shelves)

    @property
    def force_zero(self) -> Measured | None:
        """Force in N at which the shelves lie, that is, the zero error of the force sensor; None without shelves."""
        if self.shelves is None:
            return None
        up, down = self.shelves
        return Measured.from_deviation(0.5 * (up.force_N - down.force_N), 0.5 * abs(up.force_N + down.force_N))


def branch_fits_of(loop: CleanLoop) -> BranchFits:
    """Both branches of a loop, each with its fitted micro-slip, once free play has been taken out of them."""
    forward, backward = split_branches(loop)
    length = forward.length_um
    shelves = shelves_of(loop, forward, backward)
    if shelves is not None:
        play = play_of(shelves).value
        forward, backward = (
            without_shelf(branch, shelf, play) for branch, shelf in zip((forward, backward), shelves, strict=True)
        )
    middle = mean_force(loop).value
    return BranchFits(_fitted(forward, middle), _fitted(backward, middle), length, shelves)


def _fitted(branch: Branch, middle_N: float) -> FittedBranch:
    crossing = balance(branch.travel_um, branch.force_N - branch.direction * middle_N)
    return branch, settled(branch, fit_micro_slip(branch), crossing)

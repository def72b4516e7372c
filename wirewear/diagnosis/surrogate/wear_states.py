"""Wear states of a nominal run: slope, friction and stiffness of the contact at each worn volume, from its loops.

In gross slip the contact is a one-dimensional device. With s the sliding position, its force under a normal load P is
Q± = P tan(θ(s) ± φ(s)): θ the effective slope of the worn surface, odd in s, φ the friction angle, even in s (the
position-resolved friction of Jahangiri et al. 2012, read backwards). Two crossed wires of radius R, worn by a volume V
under a slip amplitude δ, are geometrically similar to another such pair of equal V R/δ⁴ if both are large against the
elastic approach: lengths along the surface go with δ, depths with δ²/R, slopes with δ/R. This V R/δ⁴ is called the
similarity of a state. A contact that sticks in its middle has no δ; its similarity is V itself.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Array
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.surrogate.layered_wires import (
    ENGAGEMENT_MPa,
    FlattenedWires,
    LayeredCase,
    LayeredWires,
    flattened_wires,
    layered_wires,
)
from wirewear.diagnosis.surrogate.loop_states import (
    EVEN_POWERS,
    FULL_SLIP,
    LIFT_POWERS,
    ODD_POWERS,
    later_scars,
    sliding,
    state_of,
    states_of,
)
from wirewear.diagnosis.surrogate.sticking import FREEDOMS, sticking_states, sticks
from wirewear.test import study_from_tables
from wirewear.test.gaps import Gap, hertz_of, unworn_stiffness_N_per_um
from wirewear.test.study import JointStudy

if TYPE_CHECKING:
    from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
    from wirewear.effects import AnyEffect, Chain
    from wirewear.results import RunResult


Profiles = Mapping[str, tuple[Array, Array]]  #: Positions and depths in µm, by body.

_KNOWN = constants("surrogate.wear_states")

#: Powers of the worn volume with which `SCAR_FIGURES` of bodies grow that wear into one another.
_CONFORMAL_GROWTH = np.array([1.0, 0.5, 0.25, 0.25])

#: Approach over the elastic contact's up to which prints are followed; the softest metal of interest, of 120 MPa under
#: steel wires' 4 650 MPa, keeps 4.3.
_SOFTEST = _KNOWN.number("deepest_print")

#: Standard deviations of the fast model's numerical freedoms: how far it and other solvers differ without a gap.
NUMERICAL: Mapping[str, float] = constants("surrogate.wear_states.freedoms").all()

#: Flattenings are followed up to this one.
DEEPEST_um = _KNOWN.number("deepest_flattening")

#: Rough layers are followed up to this height, and up to such a V R/δ⁴ at least.
HIGHEST_um, _LEAST_WORN = _KNOWN.each("highest_layer", "least_followed")


@dataclass(frozen=True, eq=False)
class WearStates:
    """States of the contact over a nominal run: row i of the arrays (n, …) describes it at the worn volume
    volume_um3[i].

    Rows are in order of increasing volume. Between rows, states are interpolated over the logarithm of the similarity.
    """

    wears: ClassVar[bool] = True  #: Whether contacts change as they wear.
    has_layers: ClassVar[bool] = True  #: Whether the effect of rough or loose layers between such bodies is computed.
    stiffening: ClassVar[float] = 1.0 / 3.0  #: Power of the load with which the contact's stiffness grows (Mindlin).
    #: Standard deviations of the fast model's numerical freedoms where contacts slide.
    sliding_freedoms: ClassVar[Mapping[str, float]] = NUMERICAL

    radius_um: float  #: Radius R of the gap across the motion (`Gap`); of crossed wires, the wires' radius.
    friction: float  #: Coefficient of friction of the run.
    normal_load_N: float  #: Load before any wear.
    fresh_area_um2: float  #: Contact area before any wear, by Hertz.
    volume_um3: Array  #: (n,) worn volume of both wires together; the first row is as good as unworn.
    slip_um: Array  #: (n,) slip amplitude δ: largest sliding position s; 1 if the contact sticks.
    similarity: Array  #: (n,) V R/δ⁴, increasing; V if the contact sticks.
    slope: Array  #: (n, 5) coefficients of θ over `ODD_POWERS` of s/δ.
    angle: Array  #: (n, 2) coefficients of φ − atan µ over `EVEN_POWERS` of s/δ.
    stiffness_N_per_um: Array  #: (n,) initial stiffness K_c of the contact, Mindlin's shape assumed.
    load_drop_N: Array  #: (n,) by how much wear has lowered the load in mid-stroke.
    lift_N: Array  #: (n, 2) coefficients over `LIFT_POWERS` of s/δ of the load beyond that in mid-stroke.
    #: (n + k, 2, 4) `SCAR_FIGURES` in µm³ and µm of the moving and of the fixed body; the last k beyond all states.
    scars: Array
    stroke_um: float = 0.0  #: Largest amplitude by which the bodies were moved; never less than the slip.
    #: (n + k, 2) skew of both wires' scars beyond the shear of a rigid sweep (`scar_skew`), as a run's elastic contact
    #: leaves it; by symmetry there is none at 90°.
    extra_skew: Array = field(default_factory=lambda: np.zeros((1, 2)))
    #: (k,) worn volume of scars beyond all states, as of a programme that ends under other conditions.
    later_um3: Array = field(default_factory=lambda: np.zeros(0))
    full_slip: float = FULL_SLIP  #: Elastic displacement of the sliding contact as a multiple of Q/K_c.
    along: float = 1.0  #: Curvature of the gap along the motion over that across (`Gap`).
    #: (n, 5) order and bends of micro-slip (`sticking`) of a contact that sticks in its middle; empty if it slides.
    yields: Array = field(default_factory=lambda: np.zeros((0, 5)))
    #: (n,) friction over the stated coefficient, where layers have friction of their own; empty if there are none.
    friction_shares: Array = field(default_factory=lambda: np.zeros(0))
    #: (m,) friction energies at which `worn_um3_per_mJ` (m,) of both bodies is known; empty if wear is proportional.
    energy_J: Array = field(default_factory=lambda: np.zeros(0))
    worn_um3_per_mJ: Array = field(default_factory=lambda: np.zeros(0))
    #: Compliance of a sliding contact's bodies beyond that of half-spaces [µm/N], which hangs on how they are held.
    held_um_per_N: float = 0.0
    #: Relative standard deviations, by name of the scatter, of quantities that the record does not state.
    unknown: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def of_run(cls, result: RunResult) -> WearStates:
        """States of a run of a contact at a point: from its sliding loops or, if no loop slides as a whole, or far
        enough to show how, from all. Raises RunError if none carries a force.
        """
        friction, load = result.study["contact"]["friction"], result.study["conditions"]["normal_load_N"]
        bodies = study_from_tables(result.study, result.label).bodies
        gap, fresh = Gap.like(load, *bodies), unworn_stiffness_N_per_um(load, *bodies)
        radius = 1e3 * gap.radius_mm
        rows = [] if sticks(result) else sliding(result, lambda loop: state_of(result, loop, friction, fresh))
        if not rows:
            return cls(
                radius_um=radius, friction=friction, normal_load_N=load, along=gap.along,
                fresh_area_um2=1e6 * float(np.pi) * hertz_of(load, *bodies).contact_radius_mm ** 2,
                **sticking_states(result, friction),
            )  # fmt: skip
        volume, *columns, scars, skews = rows
        later, *beyond = later_scars(result)
        scars, skews = (np.concatenate(both) for both in zip((scars, skews), beyond, strict=True))
        known = states_of(result, load, volume, volume * radius / columns[0] ** 4, scars, *columns)
        return cls(
            held_um_per_N=max(1.0 / float(known["stiffness_N_per_um"][0]) - 1.0 / fresh, 0.0),
            radius_um=radius,
            friction=friction,
            normal_load_N=load,
            fresh_area_um2=1e6 * float(np.pi) * hertz_of(load, *bodies).contact_radius_mm ** 2,
            extra_skew=np.nan_to_num(skews + gap.shear),
            later_um3=later,
            along=gap.along,
            **known,
        )

    @property
    def sticks(self) -> bool:
        """True if the contact sticks in its middle throughout the nominal run."""
        return self.yields.size > 0

    @property
    def freedoms(self) -> Mapping[str, float]:
        """Standard deviations, by name, of the fast model's numerical freedoms on these states."""
        return FREEDOMS if self.sticks else self.sliding_freedoms

    @property
    def doubts(self) -> Mapping[str, float]:
        """Standard deviations, by name, of unstated quantities that are the same in all repeats of the test: `unknown`
        (relative), and "compliance" in µm/N, as large as what the way in which the bodies are held gives.
        """
        return {**self.unknown, **({"compliance": self.held_um_per_N} if self.held_um_per_N else {})}

    def model_error(self, kind: type[AnyEffect]) -> float:
        """Error of the fast model in the change that an effect of this class makes, relative to that change."""
        return kind.model_error

    def reach(self, slip_um: Array) -> Array:
        """Lengths (n,) in µm with which similar states scale: the given slip amplitudes (n,), or 1 if the contact
        sticks.
        """
        return np.ones_like(slip_um) if self.sticks else slip_um

    def yielding_between(self, row: NDArray[np.intp], share: Array) -> Array:
        """Orders and bends of micro-slip (k, 5), interpolated by `share` (k,) of the way from the states `row` (k,) to
        the next. Shares above 1 count as 1. A sliding contact has the order `full_slip` in all states, and no bends.
        """
        known = self.yields if self.sticks else np.tile([self.full_slip, 1.0, 0.0, 0.0, 0.0], (self.volume_um3.size, 1))
        return np.asarray(known[row] + np.minimum(share, 1.0)[:, None] * (known[row + 1] - known[row]))

    def friction_between(self, row: NDArray[np.intp], share: Array) -> Array:
        """Friction over the stated coefficient (k,), interpolated as above; 1 without `friction_shares`."""
        known = self.friction_shares
        return known[row] + np.minimum(share, 1.0) * (known[row + 1] - known[row]) if known.size else np.ones(row.size)

    def under_layers(self) -> Self:
        """A copy that holds friction in mid-stroke in `friction_shares`, as it changes when layers wear, and no longer
        in `angle`.
        """
        known = np.tan(np.arctan(self.friction) + self.angle[:, 0]) / self.friction
        return replace(self, friction_shares=known, angle=self.angle * (np.arange(self.angle.shape[1]) > 0))

    def similar(self, worn_um3: Array, slip_um: Array) -> Array:
        """Similarities (n,) of contacts of worn volumes (n,) under slip amplitudes (n,): V R/δ⁴, or V if the contact
        sticks.
        """
        return worn_um3 if self.sticks else np.asarray(worn_um3 * self.radius_um / slip_um**4)

    @property
    def spot_radius_um(self) -> float:
        """Radius in µm of the sphere whose contact spots on a flat have the areas of this gap's."""
        return self.radius_um / float(np.sqrt(self.along))

    def open_share(self, chain: Chain) -> Array:
        """Share (n,) of the worn volume that opens the gap; retained debris fills the rest."""
        return np.asarray(1.0 - chain.retained_fraction)

    def wearing(self, setup: SurrogateInputs, chain: Chain, slip_um: Array) -> Array:  # noqa: ARG002
        """Worn volume of both bodies per friction energy in µm³/mJ at the chain's n moments. It follows the run's
        course over the energy if the states hold one. `slip_um` (n,) is not used for contacts at a point.
        """
        if not self.energy_J.size or not setup.wear_um3_per_mJ:
            return chain.wear_um3_per_mJ
        now = np.interp(chain.energy_J, self.energy_J, self.worn_um3_per_mJ)
        return np.asarray(chain.wear_um3_per_mJ / setup.wear_um3_per_mJ * now)

    def wearing_as(self, result: RunResult) -> Self:
        """A copy whose wear per friction energy is that of `result` at each energy; unchanged if the run shows no two
        energies.
        """
        energy, volume = result.evolution["accumulated_energy_J"], 1e9 * result.worn_volume_mm3
        kept = np.concatenate([[True], np.diff(energy) > 0.0])
        if np.count_nonzero(kept) == 1:
            return self
        return replace(self, energy_J=energy[kept], worn_um3_per_mJ=1e-3 * np.gradient(volume[kept], energy[kept]))

    def profiles(self, setup: SurrogateInputs, last: Chain, slip_um: float, share: float) -> Profiles:  # noqa: ARG002
        """Worn profiles by body, (positions, depths) in µm each; empty for contacts at a point.

        last: the chain with its effects at one moment alone. slip_um: slip amplitude then. share: tangential force over
        the friction (0 to 1) at the end of the stroke then, below which a part of the contact sticks.
        """
        return {}

    @property
    def least_similarity(self) -> float:
        """Similarity of the second state, 1 if there is only one; added to all similarities before their logarithm is
        taken, as the first may be 0.
        """
        return float(self.similarity[1]) if self.similarity.size > 1 else 1.0

    @cached_property
    def log_similarity(self) -> Array:
        """Logarithms (n,) of `similarity` + `least_similarity`, over which states are interpolated."""
        return np.asarray(np.log(self.similarity + self.least_similarity))

    @cached_property
    def of_scars(self) -> tuple[Array, Array]:
        """Similarities and slip amplitudes in µm (n + k,) of `scars`; beyond the last state slip remains."""
        slip = np.append(self.slip_um, np.full(self.later_um3.size, self.slip_um[-1]))
        later = self.similar(self.later_um3, slip[self.slip_um.size :])
        return np.append(self.similarity, np.maximum(later, self.similarity[-1] * (1.0 + 1e-9))), slip

    @cached_property
    def scars_growth(self) -> Array:
        """Powers (2, 4) of the similarity with which the `SCAR_FIGURES` of both bodies grow beyond the last scar."""
        similarity, _ = self.of_scars
        before = int(np.searchsorted(similarity, 0.5 * similarity[-1])) - 1
        if before < 1 or not (self.scars[[before, -1]] > 0.0).all():
            return np.broadcast_to(_CONFORMAL_GROWTH, self.scars.shape[1:])
        grown, worn = (np.log(rows[-1] / rows[before]) for rows in (self.scars, similarity))
        return np.asarray(grown / worn)

    @cached_property
    def _columns(self) -> Array:
        alone = (self.slip_um, self.stiffness_N_per_um)
        return np.column_stack([*alone, self.slope, self.angle])

    @cached_property
    def _loads(self) -> Array:
        return np.column_stack([self.slip_um, self.load_drop_N, self.lift_N])

    def between(self, row: NDArray[np.intp], share: Array) -> tuple[Array, Array, Array, Array]:
        """Slip in µm (k,), stiffness in N/µm (k,), `slope` (k, 5) and `angle` (k, 2), `share` (k,) of the way from
        states `row` (k,) to the next; shares above 1 extrapolate.
        """
        values = _on_the_way(self._columns, row, share)
        slopes = 2 + len(ODD_POWERS)
        return values[:, 0], values[:, 1], values[:, 2:slopes], values[:, slopes:]

    def loads(self, row: NDArray[np.intp], share: Array, slip_um: Array) -> tuple[Array, Array]:
        """`load_drop_N` (k,) and `lift_N` (k, 2), interpolated like `between` and scaled to slip amplitudes (k,) in
        µm.
        """
        values = _on_the_way(self._loads, row, share)
        size = (slip_um / values[:, 0]) ** 2
        return values[:, 1] * size, values[:, 2:] * size[:, None]

    def flattened(self, *, slid: bool = False) -> FlattenedWires:
        """Table of the changes of these states by flattening before any wear; slid: by prints of bodies that yield."""
        slip = float(self.slip_um[0])
        radius, stroke, share = self._proportions
        deepest = round(DEEPEST_um * self.radius_um / slip**2, 2)
        if slid:
            deepest = _rounded(min(deepest, _SOFTEST * radius**2))
        return flattened_wires(radius, stroke, deepest, share, round(self.along, 3), slid=slid)

    def layered(self) -> LayeredWires:
        """Table of what a rough layer between the bodies changes of their loops and scars."""
        slip = float(self.slip_um[0])
        radius, stroke, share = self._proportions
        return layered_wires(
            LayeredCase(
                fresh_radius=radius,
                stroke=stroke,
                highest=_rounded(HIGHEST_um * self.radius_um / slip**2),
                engagement=_rounded(1e-6 * ENGAGEMENT_MPa * slip**2 / self.normal_load_N),
                most_worn=_rounded(max(float(self.similarity[-1]), _LEAST_WORN)),
                moving_share=share,
                along=round(self.along, 3),
            )
        )

    @property
    def _proportions(self) -> tuple[float, float, float]:
        """Fresh contact's radius and stroke in slip amplitudes, and the moving wire's share of the wear, rounded."""
        slip, (moving, fixed) = float(self.slip_um[0]), self.scars[-1, :, 0]
        radius = float(np.sqrt(self.fresh_area_um2 / np.pi)) / slip
        share = float(moving / (moving + fixed)) if moving + fixed > 0.0 else 0.5
        return round(radius, 2), round(max(self.stroke_um / slip, 1.0), 2), round(share, 2)


def _rounded(value: float) -> float:
    """To three digits, so that equal cases are computed once."""
    return float(f"{value:.3g}")


def _on_the_way(columns: Array, row: NDArray[np.intp], share: Array) -> Array:
    return np.asarray(columns[row] + share[:, None] * (columns[row + 1] - columns[row]))


@dataclass(frozen=True, eq=False)
class JointStates(WearStates):
    """States of a joint, which does not wear: two equal rows, as interpolation needs two."""

    wears = has_layers = False
    stiffening: ClassVar[float] = 0.0  #: 0: a joint's stiffness is stated for any load.
    sliding_freedoms: ClassVar[Mapping[str, float]] = FREEDOMS

    @classmethod
    def of_study(cls, study: JointStudy) -> JointStates:
        """The states of a joint by its stated friction, load and stiffness. A stiffness so large that friction would
        move the joint by less than 0.01 % of the amplitude counts as that limit.
        """
        load, friction, stated = study.conditions.normal_load_N, study.contact.friction, study.contact
        # Share of the displacement amplitude that a rigid joint takes under its friction.
        rigid = friction * load / (1e-4 * study.conditions.displacement_amplitude_um)
        own = stated.contact_stiffness_N_per_mm
        rows = np.arange(2.0)
        return cls(
            radius_um=1.0,
            friction=friction,
            normal_load_N=load,
            fresh_area_um2=1.0,
            volume_um3=rows,
            slip_um=np.ones(2),
            similarity=rows,
            slope=np.zeros((2, len(ODD_POWERS))),
            angle=np.zeros((2, len(EVEN_POWERS))),
            stiffness_N_per_um=np.full(2, rigid if own == "rigid" else min(1e-3 * float(own), rigid)),
            load_drop_N=np.zeros(2),
            lift_N=np.zeros((2, len(LIFT_POWERS))),
            scars=np.zeros((2, 2, 4)),
            full_slip=1.0,
        )

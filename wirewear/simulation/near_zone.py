"""Metal that flows about a study's contact at a point: prints and residual stress of its first cycles.

Both bodies are half-spaces beneath their unworn surfaces (`solvers.stress.rubbing`), pressed by the load of the first
block and, where they slide, slid by the slip to be expected. Wear of these cycles is left out.
"""

import json
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import scipy
from threadpoolctl import threadpool_limits

from geometry.arrays import Array
from solvers import ContactProblem, PlacedBody, PressureLimit, SolverError, WearState
from solvers.errors import NotConvergedError
from solvers.laws.plasticity import Metal
from solvers.stress.half_space import HalfSpace
from solvers.stress.plastic_zone import Flowed, PlasticZone
from solvers.stress.pressing import largest_MPa
from solvers.stress.rubbing import Rubbed, Rubbing
from wirewear import reference
from wirewear.results.values import ENDLESS, FLOW, FLOW_CYCLES, FLOW_ENERGY, RATCHETTING, SKIN, PlasticStrain
from wirewear.simulation.control import point_sticks, round_contact
from wirewear.simulation.yielding import limit_of_points, spread_by_yield
from wirewear.test import Study, study_from_tables
from wirewear.test.bodies import Body
from wirewear.test.gaps import hertz_of

NEAR_ZONE = "near zone"  #: What a study's `plasticity` is called.
#: What these settings change stands in studies/yielding_wires/README.md.
#: Points over the smaller semi-axis while pressing and while sliding; margin around in larger semi-axes; most points a
#: side.
_PRESSED, _SLID, _MARGIN, _MOST = 9.0, 4.0, 4.0, 129
_LAYERS = np.asarray(0.1 * 1.1 ** np.arange(15), dtype=np.float64)  #: Over the smaller semi-axis.
_LOADS = (np.arange(1, 17) / 16) ** 2  #: Steps of the load.
#: Most cycles, and most steps from mid-stroke to its end, which are of a point or more.
_CYCLES, _STEPS = 20, 16


@dataclass(frozen=True, eq=False)
class FlowGrid:
    """Metal of both bodies, as `rubbed` left it, on even lines x (along the motion) and y in mm, at depths in mm."""

    axes_mm: tuple[Array, Array]
    depths_mm: Array
    rubbed: Rubbed

    def _index(self, places_mm: Array) -> list[Array]:
        """Indices (k,) along x and y of places (k, 2)."""
        return [(at - lines[0]) / (lines[1] - lines[0]) for at, lines in zip(places_mm.T, self.axes_mm, strict=True)]

    def printed(
        self, problem: ContactProblem, wear: WearState, left: tuple[Flowed, ...], plastic_mJ: float
    ) -> WearState:
        """The wear state with the prints of states `left` of the upper and the lower body."""

        def of(body: PlacedBody, own: Flowed, shape: tuple[int, ...]) -> Array:
            # Cubic, since pressures follow the print's curvature.
            found = scipy.ndimage.map_coordinates(-own.residual_mm[..., 2], self._index(body.node_positions), order=3)
            return np.asarray(found.reshape(shape))

        primary, secondary = left if problem.primary_is_upper else left[::-1]
        return replace(
            wear,
            primary_print=of(problem.primary, primary, wear.primary_depth.shape),
            secondary_print=of(problem.secondary, secondary, wear.secondary_depth.shape),
            plastic_mJ=plastic_mJ,
        )


@dataclass(frozen=True, eq=False)
class NearZone:
    """The near zone after pressing by a load in N, and after sliding to and fro; the same where bodies do not slide."""

    pressing: FlowGrid
    sliding: FlowGrid
    load_N: float

    def pressed(self, problem: ContactProblem, wear: WearState) -> WearState:
        """The wear state with the prints of pressing."""
        rubbed = self.pressing.rubbed
        return self.pressing.printed(problem, wear, rubbed.pressed, rubbed.pressed_mJ)

    def slid(self, problem: ContactProblem, wear: WearState) -> WearState:
        """The wear state with the prints that cycles have left."""
        rubbed = self.sliding.rubbed
        return self.sliding.printed(problem, wear, rubbed.unloaded, rubbed.work_mJ)

    def limited(self, limit: PressureLimit) -> PressureLimit:
        """The limit of pressures that prints these bodies further: up to this load, the largest there was."""
        upper, lower = self.pressing.rubbed.pressed
        deepest = float((-upper.residual_mm - lower.residual_mm)[..., 2].max())
        return limit.borne_MPa(largest_MPa(-upper.traction_MPa[..., 2]), self.load_N, deepest)

    def strains(self, driven: str, held: str) -> tuple[PlasticStrain, ...]:
        """Plastic strain that cycles have left in the bodies of these names, of those that have flowed."""
        grid, points = self.sliding, len(self.sliding.depths_mm)
        return tuple(
            PlasticStrain(name, *grid.axes_mm, grid.depths_mm, left.flow.strain.reshape(points, *left.stress.shape[1:]))
            for name, left in zip((held, driven), grid.rubbed.unloaded, strict=True)
            if left.flow.accumulated.any()
        )

    @property
    def settings(self) -> dict[str, float]:
        """Settings of a result that describe the flow of its first cycles."""
        rubbed = self.sliding.rubbed
        last = rubbed.cycles[-1] if rubbed.cycles else None
        return {
            FLOW_CYCLES: float(len(rubbed.cycles)),
            FLOW: 0.0 if last is None else last.through,
            RATCHETTING: 0.0 if last is None else last.left,
            SKIN: 0.0 if last is None else last.skin,
            ENDLESS: float(rubbed.endless),
            FLOW_ENERGY: rubbed.book.missing,
        }


def near_zone_of(study: Study) -> NearZone | None:
    """The metal about a study's contact after its first cycles; None if the study does not ask for it or no body
    yields. Raises SolverError if the metal bears no such load.
    """
    if study.contact.plasticity != NEAR_ZONE:
        return None
    return _of_tables(json.dumps(study.resolved(), sort_keys=True, default=str))


@lru_cache(maxsize=4)
def _of_tables(tables: str) -> NearZone | None:
    """What `near_zone_of` gives for the study whose resolved tables are `tables`, as JSON text."""
    whole: Study = study_from_tables(json.loads(tables), "the result")
    study = whole.driven.schedule.stretches[0].study
    limit = limit_of_points(study)
    if limit is None:
        return None
    load, slip = study.conditions.normal_load_N * study.conditions.drive.load.largest, _slip_mm(study)
    hertz = hertz_of(load, *study.bodies)
    wider = spread_by_yield(limit, load, hertz.peak_pressure_MPa)
    axes = wider * hertz.minor_semi_axis_mm, wider * hertz.major_semi_axis_mm
    try:
        pressing = _on_grid(study, load, axes, 0.0, _PRESSED)
        return NearZone(pressing, _on_grid(study, load, axes, slip, _SLID) if slip else pressing, load)
    except NotConvergedError:
        raise SolverError(
            'the metal of these bodies flows without end under this load: give a smaller one, or "limited pressure" '
            "as plasticity"
        ) from None


def _on_grid(study: Study, load_N: float, semi_axes_mm: tuple[float, float], slip_mm: float, fine: float) -> FlowGrid:
    """Metal pressed, and slid if there is a slip amplitude; semi_axes_mm: (minor, major) of the contact."""
    (minor, major), (driven, held) = semi_axes_mm, study.bodies
    curvatures = held.curvature_per_mm(), driven.curvature_per_mm()
    # The contact's middle moves on both bodies; its extents along the axes are about those of a level line of the gap.
    inverse, end = np.linalg.inv(curvatures[0] + curvatures[1]), np.array([slip_mm, 0.0])
    middle = inverse @ curvatures[1] @ end
    away = np.maximum(np.abs(middle), np.abs(middle - end))
    reach = away + _MARGIN * major * np.sqrt(np.diag(inverse) / np.linalg.eigvalsh(inverse)[-1])
    size = max(minor / fine, 2.0 * float(reach.max()) / (_MOST - 1))
    along, across = (_odd(2 * int(np.ceil(own / size)) + 1) for own in reach)
    stroke = max(round(slip_mm / size), 1) if slip_mm else 0

    def zone(body: Body) -> PlasticZone:
        space = HalfSpace(body.material, (along, across), (size, size), minor * _LAYERS)
        stress, hardening = study.tables.yields[body.name] or (np.inf, 0.0)
        # Least hardening of metal that slides, over its modulus: without, friction at the yield stress in shear finds
        # no end.
        least = 0.01 * body.material.youngs_modulus_MPa if stroke else 0.0
        return PlasticZone(space, Metal(stress, max(hardening, least)))

    zones, modulus = (zone(held), zone(driven)), reference.contact_modulus(driven.material, held.material)
    rubbing = Rubbing(zones, curvatures, modulus, study.contact.friction)
    # Shared between cores, small problems cost more than they gain.
    with threadpool_limits(limits=1, user_api="blas"):
        rubbed = rubbing.rubbed(load_N * _LOADS, stroke, max(1, -(-stroke // _STEPS)), _CYCLES if stroke else 0)
    return FlowGrid(zones[0].space.axes_mm(), zones[0].space.depths_mm, rubbed)


def _odd(least: int) -> int:
    """The least odd number from `least` on that Fourier transforms are fast for."""
    return next(n for n in range(least, 2 * least) if n % 2 and scipy.fft.next_fast_len(n) == n)


def _slip_mm(study: Study) -> float:
    """Slip amplitude in mm in gross slip of the fresh contact; 0 if it sticks or slides too far to be followed."""
    hertz, rig = hertz_of(study.conditions.normal_load_N, *study.bodies), study.tables.rig
    radius, modulus = round_contact(study, study.conditions.normal_load_N)
    amplitude = 1e-3 * study.conditions.displacement_amplitude_um - 0.5 * rig.play_mm
    if study.contact.friction == 0.0 or amplitude <= 0.0 or point_sticks(study):
        return 0.0
    contact = reference.partial_slip_point(study.conditions.normal_load_N, study.contact.friction, radius, modulus)
    compliance = rig.compliance_at_contact_mm_per_N
    slip = reference.slip_amplitude(contact, amplitude, np.inf if compliance == 0.0 else 1.0 / compliance)
    # Slip amplitude over the smaller semi-axis beyond which the flow of sliding is not followed.
    return slip if 0.0 < slip <= 8.0 * hertz.minor_semi_axis_mm else 0.0

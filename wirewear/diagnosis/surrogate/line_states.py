"""Wear states of a line contact's nominal run: the contact as its loops show it, and the worn profiles of both bodies.

The contact is a one-dimensional device as wires' is (`wear_states`). Two cylinders on flats of radius R, worn by a
cross-section A under a slip amplitude δ, are similar to others of equal A R/δ³ if scars are large against the elastic
approach. The stick branch is almost straight, as it is the bodies that give way. Profiles follow from the worn area,
the worn cross-section of both bodies together; changes by a bed of debris and a lack of oxygen are predicted by
`line_wear`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from geometry import Cylinder, RoundedFlat, TabledProfile
from geometry.arrays import Array
from wirewear.base.errors import RunError
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.surrogate import loop_states
from wirewear.diagnosis.surrogate.line_wear import EDGE, WornLine, WornLineContact, between, transformed, worn_line
from wirewear.diagnosis.surrogate.springs import yielding_of
from wirewear.diagnosis.surrogate.sticking import FREEDOMS, share_of, sticking_states, sticks
from wirewear.diagnosis.surrogate.wear_states import NUMERICAL, Profiles, WearStates
from wirewear.reference import Elastic, contact_modulus
from wirewear.test.faces import Face

if TYPE_CHECKING:
    from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
    from wirewear.effects import AnyEffect, Chain
    from wirewear.results import Loop, RunResult


_KNOWN = constants("surrogate.line_states")

#: Standard deviations of the fast model's numerical freedoms on line contacts: slopes as of wires, and the stiffness.
LINE_FREEDOMS: Mapping[str, float] = {
    "slope_factor": NUMERICAL["slope_factor"],
    "tip_factor": NUMERICAL["tip_factor"],
    "stick_factor": FREEDOMS["stick_factor"],
}

#: Shares of the rise between which a branch is fitted, and past how many travels of full slip it slides for certain.
_STUCK, _SLIDES_PAST = _KNOWN.pair("stuck"), _KNOWN.number("slides_past")

#: Elastic displacements of the sliding contact over Q/K that are tried.
_FULL_SLIPS = _KNOWN.numbers("full_slips")

#: Share of the travel that a loop slides at least.
_LEAST_SLIDING = _KNOWN.number("least_sliding")

#: Wear is followed so many times as far as the nominal run goes.
_BEYOND = _KNOWN.number("beyond")

#: Error of what bed and oxygen change of depths.
MODEL_ERROR = _KNOWN.number("model_error")

#: Effects of which that error is known.
_MODELLED = ("third_body", "contact_oxygenation")

BODIES = ("pad", "specimen")


@dataclass(frozen=True, eq=False)
class WornProfiles:
    """Profiles of one body at k worn areas, in coordinates of the scar.

    area_um2: (k,) worn area of both bodies. place: (m,) position over the scar's half-width. shape: (k, m) depth over
    the body's worn cross-section per half-width. share: of the worn area that this body loses. slip_um: slip amplitude
    of the run. beyond: distance from the scar's edge to the common half-width, in slip amplitudes.
    """

    area_um2: Array
    place: Array
    shape: Array
    share: float
    slip_um: float
    beyond: float


@dataclass(frozen=True, eq=False)
class LineStates(WearStates):
    """States of a line contact. length_um: its length. contact: the contact that wears, for `line_wear`. bodies: worn
    profiles of pad and specimen. described: True if the record states how far from the contact its bodies are held.
    """

    has_layers = False
    stiffening: ClassVar[float] = 0.0  #: 0: the bodies as a whole give way, independently of the load.
    sliding_freedoms = LINE_FREEDOMS

    length_um: float = 0.0
    contact: WornLineContact | None = None
    bodies: Mapping[str, WornProfiles] = field(default_factory=dict)
    described: bool = True
    stuck: float = 0.0  #: Half-width that sticks in the run's last loop, over Hertz's; see `_stuck`.

    @classmethod
    def of_line(cls, result: RunResult, face: Face, length_mm: float) -> LineStates:
        """States of a run of a line contact with this face of the pad, for a contact of `length_mm`.

        Raises RunError if no loop of the run carries a force, or the face differs from side to side.
        """
        if isinstance(face, TabledProfile) and not face.is_even:
            raise RunError(
                f"the pad of {result.name!r} differs from side to side, and a diagnosis takes faces that are even."
            )
        result = result.of_length(length_mm)
        study = result.study
        friction = float(study["contact"]["friction"])
        load = float(study["conditions"]["normal_load_N"])
        length_um, areas = 1e3 * length_mm, 1e6 * result.worn_volume_mm3 / length_mm
        radius, scars = 1e3 * _radius_mm(face), np.zeros((len(result.loops), 2, 4))
        full, slip, stuck = np.ones(1), 1.0, 0.0
        rows = (
            []
            if sticks(result)
            else loop_states.sliding(result, lambda loop: _row(loop, friction, loop_states.load_shares(result, loop)))
        )
        if not rows:
            states: loop_states.StatesOfLoops = sticking_states(result, friction, has_maps=False)
            last = result.loops[-1]
            stuck = _stuck(share_of(last, friction, loop_states.load_shares(result, last)))
        else:
            cycles, full, *columns = rows
            volume = length_um * np.interp(cycles, result.evolution["cycle"], areas)
            similarity, slip = volume / length_um * radius / columns[0] ** 3, float(columns[0][-1])
            states = loop_states.states_of(result, load, volume, similarity, scars, *columns)
        hertz = 1e-3 * float(result.settings["hertz_half_width_um"])
        contact = WornLineContact(
            face=face,
            load_N_per_mm=load / length_mm,
            hertz_half_width_mm=hertz,
            contact_modulus_MPa=contact_modulus(
                *(Elastic(study[body]["youngs_modulus_MPa"], study[body]["poissons_ratio"]) for body in BODIES)
            ),
            reach_mm=1e-3 * float(result.settings["patch_half_width_um"]),
            most_area_mm2=_BEYOND * 1e-6 * max(float(areas[-1]), 1e-3),
        )
        return cls(
            radius_um=radius,
            friction=friction,
            normal_load_N=load,
            fresh_area_um2=2e3 * hertz * length_um,
            length_um=length_um,
            full_slip=float(np.median(full)),
            contact=contact,
            bodies={body: _worn(result, body, contact, slip) for body in BODIES},
            stuck=stuck,
            **states,
        )

    @property
    def doubts(self) -> Mapping[str, float]:
        """Standard deviations, by name, of unstated quantities that are the same in all repeats: `unknown` (relative),
        and "compliance" in µm/N if it is not stated where the bodies are held: as large as the contact's own.
        """
        own = {} if self.described else {"compliance": self.full_slip / float(self.stiffness_N_per_um[0])}
        return {**self.unknown, **own}

    def model_error(self, kind: type[AnyEffect]) -> float:
        """Error of the fast model in the change that an effect makes, relative to it; smaller if `line_wear` computes
        the profiles.
        """
        return MODEL_ERROR if kind.name in _MODELLED else kind.model_error

    def similar(self, worn_um3: Array, slip_um: Array) -> Array:
        """Similarities (n,) of contacts of worn volumes (n,) under slip amplitudes (n,): A R/δ³, or the volume if the
        contact sticks.
        """
        if self.sticks:
            return super().similar(worn_um3, slip_um)
        return np.asarray(worn_um3 / self.length_um * self.radius_um / slip_um**3)

    def wearing(self, setup: SurrogateInputs, chain: Chain, slip_um: Array) -> Array:
        """Worn volume of both bodies per friction energy in µm³/mJ at the chain's n moments, lowered where oxygen does
        not reach the contact's middle; slip_um: (n,).
        """
        plain = super().wearing(setup, chain, slip_um)
        if not chain.oxygen_W.any():
            return plain
        changed = worn_line(self._changed(setup, chain, slip_um))
        factor = changed.factor_at(1e-6 * chain.worn_um3 / self.length_um)
        return np.asarray(plain * factor)

    def profiles(self, setup: SurrogateInputs, last: Chain, slip_um: float, share: float) -> Profiles:
        """Profiles (x, depth), each (m,) in µm, by body at the chain's only moment: the nominal run's at this worn
        area, with the width of this slip amplitude and unworn where it sticks under this share of the friction, and
        changed by debris and lack of oxygen.
        """
        area = float(last.worn_um3[0]) / self.length_um
        hertz_um = 0.5 * self.fresh_area_um2 / self.length_um
        stuck = hertz_um * self.stuck, hertz_um * _stuck(share)
        changed = self._changed(setup, last, np.array([slip_um]))
        before = worn_line(changed.plain)
        after = before if changed == changed.plain else worn_line(changed)
        worn = {body: self._profile(own, area, slip_um, before, after) for body, own in self.bodies.items()}
        return {body: _with_stuck(*own, *stuck) for body, own in worn.items()} if self.sticks else worn

    def _changed(self, setup: SurrogateInputs, chain: Chain, slip_um: Array) -> WornLineContact:
        """The contact with a chain's bed and supply of oxygen, rounded so that equal ones are computed once."""
        if self.contact is None:
            raise RunError("a line contact's states lack its contact")
        # W over 1/s, N·µm/(N·mm) make the supply one of pressure times length squared.
        power = 4e-6 * float(np.mean(chain.friction * slip_um)) * setup.frequency_Hz
        supply = float(chain.oxygen_W[-1]) / max(power, 1e-12) if chain.oxygen_W.any() else 0.0
        values = {
            "retained_fraction": min(float(chain.retained_fraction[-1]), 0.97),
            "modulus_MPa": float(chain.bed_MPa[-1]),
            "supply_mm3_MPa": supply,
            "starved_factor": float(chain.starved_factor[-1]),
        }
        rounded: dict[str, Any] = {name: float(f"{value:.6g}") for name, value in values.items()}
        return replace(self.contact, **rounded)

    def _profile(
        self, own: WornProfiles, area_um2: float, slip_um: float, before: WornLine, after: WornLine
    ) -> tuple[Array, Array]:
        half = 1e3 * before.half_width_at(1e-6 * area_um2)
        at = np.log(max(area_um2, 1e-9))
        known = np.log(np.maximum(own.area_um2, 1e-9))
        shape = between(known, own.shape, float(at), 1.3) if known.size > 1 else own.shape[0]
        # The end of a scar moves with the slip as it lies beyond the common half-width.
        wider = 1.0 + own.beyond * (slip_um - own.slip_um) / half
        x = half * wider * own.place
        lost = own.share * area_um2
        depth = shape * lost / (half * wider)
        if after is not before:
            depth = transformed(x, depth, before, after, 1e-6 * area_um2)
        return x, depth


def _stuck(share: float) -> float:
    """Half-width that sticks over that of the contact under a share of the friction, by Cattaneo (1938); none from 99 %
    on, where models differ in it by as much.
    """
    return float(np.sqrt(1.0 - share)) if share < 0.99 else 0.0


def _with_stuck(x: Array, depth: Array, before: float, after: float) -> tuple[Array, Array]:
    """A profile (m,) that is worn outside `before`, as it is if it were worn outside `after`: with the same outer end
    and cross-section, and the ratio of both slips of Cattaneo at places that correspond.
    """
    outer = float(np.abs(x[depth > EDGE * depth.max()]).max(initial=0.0))
    if before == after or not max(before, after) < outer:
        return x, depth
    # Where nothing sticks any more, places stay apart.
    ends = [0.0, max(before, 1e-3 * outer), outer], [0.0, max(after, 1e-3 * outer), outer]
    place = np.interp(np.abs(x), *ends) + np.maximum(np.abs(x) - outer, 0.0)
    out = np.clip((np.abs(x) - before) / (outer - before), 1e-3, 0.99)
    worn, wears = (_worn_share(stuck / outer, stuck / outer + out * (1.0 - stuck / outer)) for stuck in (before, after))
    changed = depth * wears / worn
    return np.sign(x) * place, changed * (np.trapezoid(depth, x) / np.trapezoid(changed, np.sign(x) * place))


def _worn_share(stuck: float, place: Array) -> Array:
    """Pressure times slip (m,) of a cylinder at places over its half-width that slip outside `stuck`, but for a factor:
    Hertz's pressure, and the integral of Cattaneo's slope of slip, √(x² − c²).
    """
    root = np.sqrt(place**2 - stuck**2)
    bent = stuck**2 * np.log((place + root) / stuck) if stuck > 0.0 else 0.0
    return np.asarray(np.sqrt(1.0 - place**2) * (place * root - bent))


def _row(loop: Loop, friction: float, of_load: Array | None = None) -> tuple[object, ...] | None:
    """Row of a loop whose load is `of_load` (n,) times the test's at its samples; one where none is given."""
    of_load = np.ones(loop.time_s.size) if of_load is None else of_load
    x = loop.relative_displacement_um
    q, p = loop.tangential_force_N, loop.normal_force_N
    p = np.where(np.isfinite(p), p, np.nanmean(p))
    travel, forward = loop_states.travelled(x)
    if (of_load == 1.0).all():
        low, top = (float(q[turn]) for turn in loop_states.turns_of(x))
        rise = top - low
        done = np.where(forward, q - low, top - q) / rise
        stuck = (done > _STUCK[0]) & (done < _STUCK[1])
        if not stuck.any():
            return None
        full, compliance = _stick(travel[stuck], done[stuck] * rise)
    else:
        slides_N = friction * float(p.sum() / of_load.sum())
        rise = 2.0 * slides_N * float(of_load.max())
        expected = rise / max(float(np.ptp(x)) - 2.0 * float(np.abs(x[np.argmin(np.abs(q))])), 1e-6)
        stiffness, full = yielding_of(x, q, of_load, slides_N, np.array(_FULL_SLIPS), expected)
        compliance = 1.0 / stiffness
    reach = full * compliance * rise
    if np.ptp(x) * (1.0 - _LEAST_SLIDING) < reach:
        return None
    stiffness = 1.0 / compliance
    s = x - full * q / stiffness
    slip = float(0.5 * np.ptp(s))
    slides = (travel > _SLIDES_PAST * reach) & loop_states.moves(x, of_load)
    sign = np.where(forward, 1.0, -1.0)
    if np.count_nonzero(slides) < len(loop_states.ODD_POWERS) + len(loop_states.EVEN_POWERS):
        return None
    slope, angle = loop_states.fitted_angles(
        sign[slides] * s[slides] / slip, sign[slides] * np.arctan2(q, p)[slides], friction
    )
    loads = loop_states.fitted_load(s[slides] / slip, (p / of_load)[slides])
    return loop.cycle, full, slip, slope, angle, stiffness, *loads


def _stick(travel_um: Array, risen_N: Array) -> tuple[float, float]:
    """F and 1/K with which F/K (1 − (1 − q)^(1/F)) of the rise passes through a branch best."""
    best: tuple[float, float, float] | None = None
    whole = float(risen_N.max()) / _STUCK[1]
    for full in _FULL_SLIPS:
        curve = full * whole * (1.0 - (1.0 - np.minimum(risen_N / whole, 1.0)) ** (1.0 / full))
        compliance = float(curve @ travel_um / (curve @ curve))
        left = float(((travel_um - compliance * curve) ** 2).sum())
        if best is None or left < best[0]:
            best = left, full, compliance
    if best is None:
        raise ValueError("a stick branch needs a shape")
    return best[1], best[2]


def _worn(result: RunResult, body: str, contact: WornLineContact, slip_um: float) -> WornProfiles:
    """A body's logged profiles in the coordinates of the scar."""
    worn = worn_line(contact)
    place = np.linspace(-1.6, 1.6, 321)
    areas, shapes = [], []
    pairs = [
        (result.scar(cycle, body), sum(result.scar(cycle, b).area_um2 for b in BODIES))
        for cycle in result.scar_cycles()
    ]
    last, total = pairs[-1]
    share = last.area_um2 / total if total > 0.0 else 0.5
    for profile, both in pairs:
        if profile.area_um2 > 0.0 and both > 1e-3 * total:
            half = 1e3 * worn.half_width_at(1e-6 * both)
            mean = profile.area_um2 / half
            shapes.append(np.interp(place * half, profile.axial_um, profile.depth_um[:, 0], left=0.0, right=0.0) / mean)
            areas.append(both)
    if not areas:
        return WornProfiles(np.array([1.0]), place, np.zeros((1, place.size)), share, slip_um, 0.0)
    half = 1e3 * worn.half_width_at(1e-6 * areas[-1])
    deep = np.flatnonzero(shapes[-1] > 0.5 * 0.03 * shapes[-1].max())
    edge = half * float(np.abs(place[deep[[0, -1]]]).mean()) if deep.size else half
    return WornProfiles(np.array(areas), place, np.array(shapes), share, slip_um, (edge - half) / slip_um)


def _radius_mm(face: Face) -> float:
    """Radius of a cylinder that falls as much as the face does at the end of its steep part."""
    match face:
        case Cylinder(radius_mm=radius):
            return radius
        case RoundedFlat(edge_radius_mm=radius):
            return radius
    x, fall = face.even.points_mm[-1]
    return x**2 / (2.0 * fall)

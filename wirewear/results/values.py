"""Values of a finished or running simulation: one loop, and the whole run with its evolution over the cycles.

Bodies are the driven, lower one and the held, upper one. A logged cycle is one whose loop or scar is recorded. Values
that grow with the length of a line contact (extensive ones: forces, energies, volumes) are of `length_mm` of it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, NoReturn, Self, TypeVar

import numpy as np

from geometry import Elastic
from geometry.arrays import Array
from solvers import Coating, Holder
from solvers.laws.layers import SurfaceLayer, bare_depth, work_through
from wirewear.base import kinds
from wirewear.base.errors import ResultError, StudyError
from wirewear.base.words import as_sentence
from wirewear.effects import Age, Seam, applied, effects_of_tables
from wirewear.loops import LoopSignals, Sensor
from wirewear.results.contact_forces import ContactForces
from wirewear.results.evolution import OF_A_BODY, Evolution, nearest_cycle
from wirewear.results.scar import WIRES, Scar, body_named, called, float_array, require_equal_lengths, require_finite
from wirewear.test import study_from_tables
from wirewear.test.lengths import Extent, extent_of, study_of_length

_IDEAL = Sensor()
_NEW = Age.new()


#: Setting with Young's modulus in MPa and Poisson's ratio of each coating, if not the body's.
ELASTIC_LAYERS = "elastic_layers"
LAYERS_OF_BODIES = "layers"  #: Setting of a result with the coatings of bodies: lists of thickness and wear factor.
#: Settings of a result with the rig's travel to either side at the first loop, by springs (µP/K) and by play.
SPRING_TRAVEL, PLAY_TRAVEL = "fresh_spring_travel_um", "fresh_play_travel_um"
#: Settings of metal that flows: cycles followed, largest plastic strain of the last one, what of it is left, 1 where
#: the metal then flowed without end, and what the balance of energy lacks.
FLOW_CYCLES, FLOW, RATCHETTING, SKIN, ENDLESS, FLOW_ENERGY = (
    f"fresh_{name}"
    for name in (
        "flow_cycles", "flow_strain_per_cycle", "ratchetting_strain_per_cycle", "skin_strain_per_cycle", "flow_endless",
        "flow_energy_error",
    )
)  # fmt: skip

YIELD_STRESS = "fresh_yield_stress_MPa"  #: Setting of a result: yield stress of the softer of bodies that yield.
#: Settings of a result with the largest pressure that the softer body bears, and its source in words.
BORNE, BORNE_IS = "borne_pressure_MPa", "borne_pressure_is"
T = TypeVar("T")
STATUSES = ("complete", "running", "failed")

#: Columns of loops that results of earlier versions lack, of wires or of line contacts.
_LATER_OF_LOOPS = ("normal_force_N", "friction_work_mJ", "tilt_deg")


def sensor_of(study: Mapping[str, object], sensor: Sensor = _IDEAL, age: Age = _NEW) -> Sensor:
    """`sensor` with the sensor effects of a study and its holder's mass added to its own errors, as at the age `age`.
    study: resolved tables, as results hold them. Raises StudyError if the study has an effect that is not installed
    here.
    """
    try:
        effects = effects_of_tables(study.get("effects", []))
    except ValueError as problem:
        raise StudyError(as_sentence(f"effects of the study {study.get('name', '')!r} {problem}")) from None
    rig = Holder(1.0)
    if applied(effects, Seam.HOLDER, rig, age).mass_kg > 0.0:
        rig = applied(effects, Seam.HOLDER, study_from_tables(study, "the run's study").tables.rig, age)
    # From kg mm/N.
    swings = replace(sensor, swing_s2=1e-3 * rig.mass_kg * rig.compliance_at_contact_mm_per_N)
    return applied(effects, Seam.SENSOR, swings, age)


def age_at(result: RunResult, cycle: int) -> Age:
    """The cycles and the friction energy up to `cycle`, interpolated between measured cycles; 0 J if none is."""
    cycles, energy_J = result.evolution["cycle"], result.evolution["accumulated_energy_J"]
    return Age(float(cycle), float(np.interp(cycle, cycles, energy_J)) if cycles.size else 0.0)


def read_loop(loop: Loop, sensor: Sensor, period_s: float) -> Loop:
    """A copy of a loop with displacements and forces as `sensor` reads them; its friction work stays the true one.
    The relative displacement becomes the displacement read, less the true one of the held body's holder. period_s:
    duration of a cycle.
    """
    known = None if np.isnan(loop.normal_force_N).any() else loop.normal_force_N
    truth = LoopSignals(loop.time_s, loop.displacement_um, loop.tangential_force_N, known, period_s)
    read = sensor.read(truth)
    holder_um = loop.displacement_um - loop.relative_displacement_um
    normal = loop.normal_force_N if read.normal_force_N is None else read.normal_force_N
    return replace(
        loop,
        displacement_um=read.displacement_um,
        relative_displacement_um=read.displacement_um - holder_um,
        tangential_force_N=read.tangential_force_N,
        normal_force_N=normal,
    )


def read_loops(result: RunResult, sensor: Sensor = _IDEAL) -> tuple[Loop, ...]:
    """Copies of the result's loops as `sensor` reads them with the study's sensor effects, without noise."""
    if not result.study.get("effects") and sensor == _IDEAL:
        return result.loops
    sensors = [sensor_of(result.study, sensor, age_at(result, loop.cycle)) for loop in result.loops]
    period_s = 1.0 / float(result.study["conditions"]["frequency_Hz"])
    return tuple(
        loop if own == _IDEAL else read_loop(loop, own, period_s)
        for loop, own in zip(result.loops, sensors, strict=True)
    )


def extensive(name: str) -> bool:
    """True if a quantity with this name grows with the length of a line contact: its unit is N, mJ, J or mm³."""
    return name.endswith(("_N", "_mJ", "_J", "_mm3"))


def scaled(columns: Mapping[str, Array], factor: float) -> dict[str, Array]:
    """Copies of a line contact's columns for `factor` times its length: extensive quantities are multiplied by it."""
    return {name: column * factor if extensive(name) else column for name, column in columns.items()}


@dataclass(frozen=True, eq=False)
class Loop:
    """One fretting cycle, from mid-stroke towards +x; the last sample does not repeat the first.

    All arrays have shape (n,). `displacement_um` is the drive of the moving body relative to the ground,
    `relative_displacement_um` that of its holder relative to the fixed body's holder; `tangential_force_N` is positive
    when it resists motion in +x; `friction_work_mJ` is cumulated over the loop; `tilt_deg` is the holder's. Columns
    that results of earlier versions lack are NaN throughout.

    Raises ResultError if arrays differ in length, are empty or are not finite.
    """

    cycle: int
    time_s: Array
    displacement_um: Array
    relative_displacement_um: Array
    tangential_force_N: Array
    normal_force_N: Array
    friction_work_mJ: Array
    tilt_deg: Array = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        where = f"loop of cycle {self.cycle}"
        if not np.size(self.tilt_deg):
            object.__setattr__(self, "tilt_deg", np.full(np.shape(self.time_s), np.nan))
        columns = {name: float_array(f"{where}: {name}", getattr(self, name), 1) for name in LOOP_COLUMNS}
        require_equal_lengths(where, columns)
        for name, column in columns.items():
            if not column.size:
                raise ResultError(f"{where}: {name} must hold at least one sample")
            if name not in _LATER_OF_LOOPS or not np.isnan(column).all():
                require_finite(f"{where}: {name}", column)
            object.__setattr__(self, name, column)


LOOP_COLUMNS = tuple(f.name for f in fields(Loop) if f.name != "cycle")


Forces = TypeVar("Forces", Loop, ContactForces)


def longer(one: Forces, factor: float) -> Forces:
    """A copy of a line contact's loop or contact forces for `factor` times its length."""
    return replace(one, **{f.name: getattr(one, f.name) * factor for f in fields(one) if extensive(f.name)})


@dataclass(frozen=True, eq=False)
class PlasticStrain:
    """Plastic strain (l, n_x, n_y, 6) that first cycles leave in a body of this name: tensor components in the order of
    `TENSOR_PLACES`, in the axes of the test, at depths (l,) below the unworn surface and on lines along and across the
    motion, evenly spaced about the point of first contact.
    """

    body: str
    along_mm: Array
    across_mm: Array
    depths_mm: Array
    strain: Array


@dataclass(frozen=True, eq=False)
class RunResult:
    """All results of one run, that is, of one variant of a study.

    `bodies` are (driven, lower one; held, upper one). `length_mm` is the length of a line contact that values are of,
    None for other contacts. `study` is the resolved study, `settings` are mesh sizes, numbers of unknowns and the like
    that followed from it, `quality` the worst residuals by name (see `health`), `versions` those of the programs used,
    `timings_s` wall times, `message` why a run is not complete. `path` is the file it was read from, which is not
    written; `contact_forces` are empty in files of earlier versions, `plastic_strain` unless metal flows; `label` names
    the run in pictures: its variant, or else its name.

    Raises ResultError if the status is not complete, running or failed, or a scar or force is of a body not in
    `bodies`.
    """

    name: str
    variant: str
    fidelity: str
    status: str
    message: str
    study: Mapping[str, Any]
    loops: tuple[Loop, ...]
    evolution: Evolution
    scars: tuple[Scar, ...]
    settings: Mapping[str, Any]
    quality: Mapping[str, float]
    versions: Mapping[str, str]
    timings_s: Mapping[str, float]
    path: Path | None = None
    contact_forces: tuple[ContactForces, ...] = ()
    contact_kind: str = kinds.CROSSED_WIRES
    bodies: tuple[str, str] = WIRES
    length_mm: float | None = None
    plastic_strain: tuple[PlasticStrain, ...] = ()
    label: str = field(init=False)

    def __post_init__(self) -> None:
        if self.status not in STATUSES:
            raise ResultError(f"status must be one of {', '.join(STATUSES)}, not {self.status!r}")
        columns = [
            f"{start}{body}{unit}"
            for start, unit in zip(OF_A_BODY, ("_mm3", "_um"), strict=True)
            for body in self.bodies
        ]
        if missing := [name for name in columns if name not in self.evolution and self.evolution["cycle"].size]:
            raise ResultError(f"evolution: column(s) missing: {', '.join(missing)}")
        object.__setattr__(self, "label", self.variant or self.name)
        for body in {*(scar.body for scar in self.scars), *(forces.body for forces in self.contact_forces)}:
            if body not in self.bodies:
                raise ResultError(f"{self.label}: the bodies are {' and '.join(self.bodies)}, and {body!r} is none")

    @property
    def extent(self) -> Extent:
        """The contact's extent across its motion: a length for a line contact, none at a point."""
        return extent_of(self.length_mm)

    @property
    def full_name(self) -> str:
        """ "name, variant", or the name alone without a variant."""
        return f"{self.name}, {self.variant}" if self.variant else self.name

    def of_kind(self, contact_kind: str) -> Self:
        """The result itself; ResultError unless its kind of contact has this name."""
        return self if self.contact_kind == contact_kind else self._refused(contact_kind.replace("-", " "))

    def with_maps(self) -> Self:
        """The result itself; ResultError for a line contact, whose scars are profiles instead of maps."""
        if self.extent.worn == "scars":
            return self
        return self._refused("a contact at a point, such as crossed wires,")

    def _refused(self, needed: str) -> NoReturn:
        own = self.contact_kind.replace("-", " ")
        raise ResultError(f"{self.path or self.full_name} is a result of a {own}, where one of {needed} is needed.")

    def is_upper(self, body: str) -> bool:
        """True if `body` is the held, upper one; ResultError if it is neither body."""
        return body_named(body, self.label, self.bodies) == self.bodies[1]

    def times(self, length_mm: float | None) -> float:
        """Ratio of the length `length_mm` (None: 1 mm) to that of this line contact; 1 for a contact at a point."""
        return self.extent.share / extent_of(length_mm).share

    def of_length(self, length_mm: float) -> Self:
        """A copy of a line contact's result for a contact of `length_mm`."""
        factor = self.times(length_mm)
        return replace(
            self,
            length_mm=length_mm,
            study=study_of_length(self.study, length_mm),
            loops=tuple(longer(loop, factor) for loop in self.loops),
            evolution=Evolution(scaled(self.evolution, factor)),
            scars=tuple(replace(scar, length_mm=length_mm) for scar in self.scars),
            contact_forces=tuple(longer(one, factor) for one in self.contact_forces),
        )

    def of_extent(self, extent: Extent) -> RunResult:
        """A copy for a contact of another extent; a contact at a point is returned unchanged."""
        return extent.of_result(self)

    @property
    def computed(self) -> RunResult:
        """The result as it was computed: for a line contact, that of 1 mm of length."""
        return self if self.extent.share == 1.0 else self.of_length(1.0)

    @property
    def worn_volume_mm3(self) -> Array:
        """Worn volume (n,) of both bodies together at the cycles of the evolution."""
        driven, other = (self.evolution[f"worn_volume_{body}_mm3"] for body in self.bodies)
        return np.asarray(driven + other)

    def layer_faces_um(self, body: str) -> Array:
        """Depths (n,) in µm of the lower faces of a body's coatings, the outermost first; empty without coatings."""
        return 1e3 * work_through(self._layers(body))[0][1:]

    def worn_through(self, body: str) -> tuple[float | None, ...]:
        """For each coating of a body, the outermost first: the cycle at which it was first worn through, None if it was
        not.

        Interpolated by a power law of the cycles, for the depth to which the body would have worn without coatings,
        from the last two cycles measured before, up to the first one after.
        """
        layers, cycles = self._layers(body), self.evolution["cycle"]
        bare = bare_depth(layers, 1e-3 * np.maximum.accumulate(self.evolution[f"max_depth_{body}_um"]))
        found: list[float | None] = []
        for through in work_through(layers)[1][1:]:
            later = int(np.searchsorted(bare, through))
            if later == len(bare):
                found.append(None)
            elif later == 0 or bare[later - 1] <= 0.0:
                found.append(float(cycles[later] * through / bare[later]))
            else:
                # What is worn through wears by other pressures: of the measured cycles, those before show more.
                first = later - 2 if later > 1 and 0.0 < bare[later - 2] < bare[later - 1] else later - 1
                known = np.log(np.array([bare[first : first + 2], cycles[first : first + 2]]))
                slope = (known[1, 1] - known[1, 0]) / (known[0, 1] - known[0, 0])
                predicted = np.exp(known[1, 0] + slope * (np.log(through) - known[0, 0]))
                found.append(float(min(predicted, cycles[later])))
        return tuple(found)

    def coating(self, body: str, below: Elastic) -> Coating | None:
        """The unworn layers on a body of material `below`, as its compliance takes them; None for none of their own."""
        own = self.settings.get(ELASTIC_LAYERS, {}).get(body)
        if own is None:
            return None
        sheets = zip(self._layers(body), own, strict=True)
        return Coating(tuple((layer.thickness_mm, Elastic(*constants)) for layer, constants in sheets), below)

    def _layers(self, body: str) -> list[SurfaceLayer]:
        stated = self.settings.get(LAYERS_OF_BODIES, {}).get(body, ())
        return [SurfaceLayer(1e-3 * thickness_um, factor) for thickness_um, factor in stated]

    def loop(self, cycle: float) -> Loop:
        """The loop logged nearest to `cycle`, by ratio; ResultError, naming the cycles, if none is within a
        factor 2.
        """
        return _nearest(cycle, self.loops, lambda loop: loop.cycle, "loops")

    def scar(self, cycle: float, body: str) -> Scar:
        """A body's scar logged nearest to `cycle`, by ratio; ResultError as for `loop`, or if there is no such body."""
        body = body_named(body, self.label, self.bodies)
        return _nearest(cycle, self.scars_of(body), lambda scar: scar.cycle, f"scars of the {called(body)}")

    def called(self, body: str) -> str:
        """A body's name in sentences and headings, such as "moving wire" or, for a lower or upper body of a known
        shape, "ball (upper)".
        """
        shape = self.study.get("bodies", {}).get(body, {}).get("shape")
        return f"{shape} ({body})" if shape and body in ("lower", "upper") else called(body)

    def scars_of(self, body: str) -> list[Scar]:
        """Scars of the body with this name in the order of logging; empty if there are none."""
        return [scar for scar in self.scars if scar.body == body]

    def forces(self, cycle: float, body: str) -> ContactForces:
        """Contact forces on a body logged nearest to `cycle`, by ratio; ResultError as for `scar`, or without any."""
        body = body_named(body, self.label, self.bodies)
        forces = [one for one in self.contact_forces if one.body == body]
        if not forces:
            raise ResultError(
                f"{self.label}: no contact forces of the {called(body)} are recorded: the run was asked for none "
                "(contact_states in [log]), or is of an earlier version; run it again"
            )
        return _nearest(cycle, forces, lambda one: one.cycle, f"contact forces of the {called(body)}")

    def scar_cycles(self) -> tuple[int, ...]:
        """Cycles at which scars of both bodies are logged, increasing."""
        driven, other = ({scar.cycle for scar in self.scars_of(body)} for body in self.bodies)
        return tuple(sorted(driven & other))


def _nearest(cycle: float, items: Sequence[T], cycle_of: Callable[[T], int], what: str) -> T:
    wanted = nearest_cycle(cycle, [cycle_of(item) for item in items], what)
    return next(item for item in items if cycle_of(item) == wanted)

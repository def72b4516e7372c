"""The keys of a study for what drives a cycle: displacement and normal load over time, and bulk stresses of the bodies.

Bulk stress is what a body carries besides the contact, by tension, bending and torsion.
"""

from collections.abc import Callable, Mapping, Sequence
from math import degrees, radians
from typing import Annotated, Any, TypeVar

from pydantic import Field, PlainSerializer, PlainValidator

from geometry import Elastic
from solvers import BulkStress, Drive, LoadCycle, SolverError, Waveform, trapezoidal, triangular
from wirewear.base.units import Quantity
from wirewear.base.words import shown
from wirewear.test import keys

_POINTS = "points"
_NAMED = {"sinusoidal": Waveform(), "triangular": triangular()}
_DWELL = Quantity("1", 0.0, 0.5)
_HARMONIC = {
    "amplitude_share": Quantity("1", -10.0, 10.0),
    "lag_deg": Quantity("deg", -360.0, 360.0),
    "frequency_ratio": Quantity("1", 1, 8, whole=True),
}

Made = TypeVar("Made")

MOTION = (
    'displacement over time: "sinusoidal", "triangular", or a table: trapezoidal, which rests at both ends for a '
    "dwell_share of the cycle each, or points of [share of the cycle, displacement over its amplitude]"
)
LOAD_CYCLE = (
    "the normal load within each cycle, a table: 1 + amplitude_share cos(frequency_ratio × cycle − lag_deg), from the "
    "drive's rest at +amplitude on, or points of [share of the cycle, share of the load]; the contact opens where it "
    "comes to 0; without it the load stays"
)
BULK = (
    "stress that it carries beside the contact, by tension, bending and torsion in each cycle"  #: Meaning of the key.
)


def _points(value: object) -> tuple[tuple[float, float], ...]:
    # No points at all would stand for a cosine.
    return keys.pairs_of(value or None, "[[0, 1], [0.5, -1], [1, 1]]", given="gives points =", must="give")


def _made(value: object, make: Callable[[], Made]) -> Made:
    try:
        return make()
    except SolverError as problem:
        raise ValueError(f"is {shown(value)}, but {problem}") from None


def _waveform(value: object) -> Waveform:
    """The waveform that a key's value describes; ValueError if it describes none."""
    match value:
        case Waveform():
            return value
        case str(name) if name in _NAMED:
            return _NAMED[name]
        case {"name": "trapezoidal", "dwell_share": dwell, **rest} if not rest:
            return _made(value, lambda: trapezoidal(float(_DWELL(dwell))))
        case {"points": points, **rest} if not rest:
            return _made(value, lambda: Waveform(_points(points)))
    raise ValueError(
        f'is {shown(value)}, but must be "triangular" or "sinusoidal", or a table such as '
        '{ name = "trapezoidal", dwell_share = 0.1 } or { points = [[0, 1], [0.3, -1], [1, 1]] }'
    )


def _described(waveform: Waveform) -> str | dict[str, Any]:
    for name, own in _NAMED.items():
        if own == waveform:
            return name
    dwell = 2.0 * waveform.points[1][0]
    if 0.0 < dwell < 0.5 and waveform == trapezoidal(dwell):
        return {"name": "trapezoidal", "dwell_share": dwell}
    return {_POINTS: waveform.points}


def _load_cycle(value: object) -> LoadCycle:
    """The normal load over a cycle that a key's value describes; ValueError if it describes none."""
    if isinstance(value, LoadCycle):
        return value
    if isinstance(value, Mapping) and set(value) == {_POINTS}:
        return _made(value, lambda: LoadCycle(points=_points(value[_POINTS])))
    if not isinstance(value, Mapping) or "amplitude_share" not in value or set(value) - set(_HARMONIC):
        raise ValueError(
            f"is {shown(value)}, but must be a table such as {{ amplitude_share = 0.5, lag_deg = 90, frequency_ratio = "
            "1 } or { points = [[0, 1], [0.5, 0], [1, 1]] }"
        )
    try:
        found = {key: quantity(value[key]) for key, quantity in _HARMONIC.items() if key in value}
    except ValueError as problem:
        raise ValueError(f"is {shown(value)}, one of whose numbers {problem}") from None
    amplitude, lag, ratio = (found.get(key, other) for key, other in zip(_HARMONIC, (0.0, 0.0, 1), strict=True))
    return _made(value, lambda: LoadCycle(float(amplitude), radians(float(lag)), int(ratio)))


def _described_load(load: LoadCycle) -> dict[str, Any]:
    if load.points:
        return {_POINTS: load.points}
    values = (load.amplitude, round(degrees(load.lag_rad), 9), load.ratio)
    return dict(zip(_HARMONIC, values, strict=True))


#: A key that takes a waveform of the displacement.
MotionKey = Annotated[Waveform, PlainValidator(_waveform), PlainSerializer(_described)]
#: A key that takes the normal load in the course of a cycle.
LoadCycleKey = Annotated[LoadCycle, PlainValidator(_load_cycle), PlainSerializer(_described_load)]


def drive_of(amplitude_um: float, motion: Waveform, load: LoadCycle | None) -> Drive:
    """The drive as the solvers take it: amplitude (given in µm) and waveform of the displacement, and the normal load
    over the cycle, constant for None; without bulk stresses.
    """
    return Drive(1e-3 * amplitude_um, motion, load or LoadCycle())


Stress = Annotated[float, PlainValidator(Quantity("MPa", -1e4, 1e4))]
StressAmplitude = Annotated[float, PlainValidator(Quantity("MPa", 0.0, 1e4))]
Phase = Annotated[float, PlainValidator(Quantity("deg", -360.0, 360.0))]


class BulkTable(keys.Table):
    """Keys of one body's bulk stress along its own axis at the contact: mean + amplitude cos(cycle − phase), where the
    cycle begins with the drive at +amplitude.
    """

    axial_stress_MPa: Stress = Field(0.0, description="mean axial stress, tension positive", examples=[300.0])
    axial_stress_amplitude_MPa: StressAmplitude = Field(0.0, description="amplitude of the axial stress")
    bending_stress_MPa: Stress = Field(0.0, description="mean bending stress at the contact, tension there positive")
    bending_stress_amplitude_MPa: StressAmplitude = Field(0.0, description="amplitude of the bending stress")
    torsion_stress_MPa: Stress = Field(0.0, description="mean shear stress by torsion at the surface of a round bar")
    torsion_stress_amplitude_MPa: StressAmplitude = Field(0.0, description="amplitude of the shear stress by torsion")
    phase_deg: Phase = Field(0.0, description="by how much the stress comes after the drive")

    def of(self, material: Elastic, *, plane_strain: bool = False) -> BulkStress:
        return BulkStress(
            material,
            (self.axial_stress_MPa, self.bending_stress_MPa, self.torsion_stress_MPa),
            (self.axial_stress_amplitude_MPa, self.bending_stress_amplitude_MPa, self.torsion_stress_amplitude_MPa),
            radians(self.phase_deg),
            plane_strain,
        )

    def unfit(self, *, is_round: bool) -> str | None:
        """The rest of a message "bulk ..." if a body cannot carry this stress: torsion of a body that is not round.
        None if it can.
        """
        if (self.torsion_stress_MPa or self.torsion_stress_amplitude_MPa) and not is_round:
            return "gives a torsion stress, which is of round bars, wires and tubes alone"
        return None


def bulk_of(
    bodies: Sequence[tuple[BulkTable | None, Elastic]], *, plane_strain: bool = False
) -> tuple[BulkStress, ...]:
    """(driven, held): bulk stresses as the solvers take them, 0 for a body without a table; empty if neither has one.
    bodies: table and elastic constants of the driven and the held body. plane_strain: True for planar bodies.
    """
    if all(table is None for table, _ in bodies):
        return ()
    return tuple((table or BulkTable()).of(material, plane_strain=plane_strain) for table, material in bodies)

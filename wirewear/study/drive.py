"""Keys that say how a cycle is driven: displacement and normal load in its course."""

from collections.abc import Callable, Mapping
from math import degrees, radians
from typing import Annotated, Any, TypeVar

from pydantic import PlainSerializer, PlainValidator

from solvers import Drive, LoadCycle, SolverError, Waveform, trapezoidal, triangular
from wirewear.base.errors import Quantity, shown

_POINTS = "points"
_NAMED = {"sinusoidal": Waveform(), "triangular": triangular()}
_DWELL = Quantity("1", 0.0, 0.5)
_HARMONIC = {
    "amplitude_share": Quantity("1", -10.0, 10.0),
    "lag_deg": Quantity("deg", -360.0, 360.0),
    "frequency_ratio": Quantity("1", 1, 8, whole=True),
}

Made = TypeVar("Made")


def _points(value: object) -> tuple[tuple[float, float], ...]:
    pairs = value if isinstance(value, list | tuple) else [None]
    numbers = [pair for pair in pairs if isinstance(pair, list | tuple) and len(pair) == 2]
    if len(numbers) < max(len(pairs), 2) or any(
        isinstance(x, bool) or not isinstance(x, int | float) for pair in numbers for x in pair
    ):
        raise ValueError(f"gives points = {shown(value)}, but must give pairs such as [[0, 1], [0.5, -1], [1, 1]]")
    return tuple((float(time), float(share)) for time, share in numbers)


def _made(value: object, make: Callable[[], Made]) -> Made:
    try:
        return make()
    except SolverError as problem:
        raise ValueError(f"is {shown(value)}, but {problem}") from None


def _waveform(value: object) -> Waveform:
    """The waveform that a key's value describes; ValueError when there is none such."""
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
    """The course of the load that a key's value describes; ValueError when there is none such."""
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


def _told(load: LoadCycle) -> dict[str, Any]:
    if load.points:
        return {_POINTS: load.points}
    values = (load.amplitude, round(degrees(load.lag_rad), 9), load.ratio)
    return dict(zip(_HARMONIC, values, strict=True))


#: A key that takes a waveform of the displacement.
MotionKey = Annotated[Waveform, PlainValidator(_waveform), PlainSerializer(_described)]
#: A key that takes the normal load in the course of a cycle.
LoadCycleKey = Annotated[LoadCycle, PlainValidator(_load_cycle), PlainSerializer(_told)]

MOTION = (
    'displacement over time: "sinusoidal", "triangular", or a table: trapezoidal, which rests at both ends for a '
    "dwell_share of the cycle each, or points of [share of the cycle, displacement over its amplitude]"
)
LOAD_CYCLE = (
    "the normal load within each cycle, a table: 1 + amplitude_share cos(frequency_ratio × cycle − lag_deg), from the "
    "drive's rest at +amplitude on, or points of [share of the cycle, share of the load]; the contact opens where it "
    "comes to 0; without it the load stays"
)


def drive_of(amplitude_um: float, motion: Waveform, load: LoadCycle | None) -> Drive:
    """What a test's conditions come to."""
    return Drive(1e-3 * amplitude_um, motion, load or LoadCycle())

"""Layouts of observables at some sites and cycles."""

from wirewear.diagnosis.observe import Observable, Site, Sites, channels
from wirewear.diagnosis.observe.along_branches import KneePeak, PlateauForce, ShelfTravel, Stick
from wirewear.diagnosis.observe.channels import Energy, LargestForce, SlipAmplitude
from wirewear.diagnosis.observe.reduction import Layout, all_observables
from wirewear.diagnosis.observe.scars import ProfileDepths, ScarFigures, ScarSkew

CYCLES = (1, 300, 10_000, 100_000)


#: Some numbers of every observable of loops.
SITES: dict[type[Observable], list[Site]] = {
    PlateauForce: [
        Site(cycle, sign, sign * at) for cycle in CYCLES for sign in (1, -1) for at in (-20.0, 0.0, 46.0, 54.0)
    ],
    Stick: [Site(cycle, sign, force) for cycle in CYCLES for sign in (1, -1) for force in (-0.6, 0.0, 0.6)],
    ShelfTravel: [Site(cycle, sign, 0.1) for cycle in CYCLES for sign in (1, -1)],
    KneePeak: [Site(cycle, sign) for cycle in CYCLES for sign in (1, -1)],
    channels.Amplitude: [Site(cycle) for cycle in CYCLES],
    channels.NormalForce: [Site(cycle) for cycle in CYCLES],
    channels.NormalForceByDirection: [Site(cycle) for cycle in CYCLES],
    channels.NormalForceAtEnds: [Site(cycle) for cycle in CYCLES],
    channels.NormalForceBySides: [Site(cycle) for cycle in CYCLES],
    Energy: [Site(cycle) for cycle in CYCLES],
    SlipAmplitude: [Site(cycle) for cycle in CYCLES],
    LargestForce: [Site(cycle) for cycle in CYCLES],
    ScarFigures: [Site(CYCLES[-1], body=body, figure="depth") for body in ("moving", "fixed")],
    ScarSkew: [Site(CYCLES[-1], body=body) for body in ("moving", "fixed")],
    # Wires have none.
    ProfileDepths: [],
}


def layout(*kinds: type[Observable]) -> Layout:
    return at_sites(*((one, SITES[type(one)]) for one in all_observables() if not kinds or type(one) in kinds))


def at_sites(*observables: tuple[Observable, list[Site]]) -> Layout:
    return Layout.of((observable, Sites.of(sites)) for observable, sites in observables)

"""Public names of 1.0.0 go on working, those that have changed with a warning (docs/promises.md)."""

import inspect
from collections import ChainMap
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any, cast

import pytest

import wirewear
from solvers import WearRates
from wirewear.diagnosis.observe import ModelLoops
from wirewear.effects import Age, Chain, Effect, Seam
from wirewear.stress.life import BodyLife

#: Names below `wirewear`, one a line, with their parameters where they are called.
NAMES = Path(__file__).parents[1].joinpath("data", "names_1.0.0.txt").read_text(encoding="utf-8").splitlines()


def reached(name: str) -> Any:
    """What a name below `wirewear` stands for; of what objects alone have, its annotation in their class."""
    found: Any = wirewear
    for part in name.split("."):
        if isinstance(found, ModuleType) or hasattr(found, part):
            found = getattr(found, part)
        else:
            found = ChainMap(*({**vars(base), **inspect.get_annotations(base)} for base in found.__mro__))[part]
    return found


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_every_public_name_of_1_0_0_is_there_and_takes_what_it_took() -> None:
    assert len(NAMES) == 492
    lost = []
    for line in NAMES:
        name, _, parameters = line.rstrip(")").partition("(")
        try:
            found = reached(name)
        except (AttributeError, KeyError):
            lost.append(line)
            continue
        if parameters:
            known = inspect.signature(found).parameters
            lost += [f"{name}: {one}" for one in parameters.split(", ") if one.lstrip("*") not in known]
    assert lost == []


def test_names_that_have_changed_warn() -> None:
    life = object.__new__(BodyLife)
    object.__setattr__(life, "initiation", None)
    with pytest.warns(DeprecationWarning, match="initiation"):
        assert life.begun is None
    loops = object.__new__(ModelLoops)
    object.__setattr__(loops, "predicted", "loops")
    with pytest.warns(DeprecationWarning, match="predicted"):
        assert str(loops.course) == "loops"
    with pytest.warns(DeprecationWarning, match="distinguished_by"):
        assert wirewear.effects.told_apart_by is wirewear.effects.distinguished_by


def test_an_effect_that_says_by_its_former_method_what_it_does_to_a_chain_goes_on_to() -> None:
    with pytest.warns(DeprecationWarning, match="predicted"):

        @dataclass(frozen=True)
        class Worn(Effect[WearRates]):
            """An effect as 1.0.0 had it."""

            name, seam = "worn", Seam.WEAR

            def changed(self, described: WearRates, _age: Age) -> WearRates:
                return described

            def foreseen(self, chain: Chain) -> Chain:
                return chain

    chain = cast("Chain", object())
    assert Worn().predicted(chain) is chain

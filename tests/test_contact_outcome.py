"""What a converged contact says of itself."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from solvers.newton import outcome


@pytest.mark.parametrize(("slip_mm", "told"), [(1e-6, 0.1), (1e-17, 0.0)])
def test_slip_that_is_round_off_has_no_direction_that_friction_could_miss(
    monkeypatch: pytest.MonkeyPatch, slip_mm: float, told: float
) -> None:
    """One node under pressure whose friction lies 0.1 rad off the slip; the bodies close by a micrometre."""
    monkeypatch.setattr(outcome, "unbalanced_force", lambda *_: 0.0)
    system = SimpleNamespace(friction=SimpleNamespace(none=False), compliance=SimpleNamespace(layer=0.0))
    conditions = SimpleNamespace(
        system=system, count=1, world=lambda normal, tangential: np.column_stack([tangential, normal])
    )
    state = SimpleNamespace(
        normal=np.array([1000.0]),
        tangential=np.array([[600.0, 0.0]]),
        slip=slip_mm * np.array([[np.cos(0.1), np.sin(0.1)]]),
        gap=np.zeros(1),
        elastic=1e-3,
        holder_x=0.0,
        height=0.0,
        tilt=0.0,
    )
    friction = SimpleNamespace(stick=np.array([False]), direction=np.array([[-1.0, 0.0]]))
    found = outcome.converged_outcome(
        cast("Any", conditions), cast("Any", state), np.array([True]), cast("Any", friction), 3
    )
    assert found.slip_direction_error == pytest.approx(told, abs=1e-9)
    assert found.slip_length[0] == pytest.approx(slip_mm)

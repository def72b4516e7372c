"""Fixtures of tests of records."""

from typing import Any

import pytest

from tests.records.loop_files import SAMPLES, FREQUENCY_Hz
from tests.synthetic_loops import Recipe, SyntheticLoop


@pytest.fixture(scope="module")
def cycle() -> tuple[Any, Any, Any]:
    """Time [s], displacement [µm] and force [N] of one cycle."""
    time, displacement, force = SyntheticLoop(Recipe()).sampled(SAMPLES)
    return time / FREQUENCY_Hz, displacement, force

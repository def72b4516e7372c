"""Names of 1.0.0 go on working, with a warning (docs/promises.md)."""

import pytest

from wirewear.stress.life import BodyLife


def test_the_earlier_name_of_a_cracks_initiation_works_with_a_warning() -> None:
    life = object.__new__(BodyLife)
    object.__setattr__(life, "initiation", None)
    with pytest.warns(DeprecationWarning, match="initiation"):
        assert life.begun is None

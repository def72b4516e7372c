"""Tasks in processes of their own: their results, their reports, their errors."""

import pytest

from solvers import SolverError
from wirewear.base.engine import LocalProcesses
from wirewear.simulation import NoObserver, Observer
from wirewear.simulation.observers import Moment
from wirewear.simulation.together import run_side_by_side


class Listener(NoObserver):
    """Keeps what it hears."""

    def __init__(self) -> None:
        self.stages: list[str] = []
        self.cycles: list[float] = []

    def stage(self, text: str) -> None:
        self.stages.append(text)

    def moved(self, moment: Moment) -> None:
        self.cycles.append(moment.cycle)


def succeed(observer: Observer) -> str:
    observer.stage("preparing")
    for cycle in range(5):
        observer.moved(Moment(float(cycle), 5, 0.0, 0.0, 0.2 * cycle, 0.1))
    return "done"


def fail(observer: Observer) -> str:
    observer.stage("failing")
    raise SolverError("the contact did not converge")


@pytest.mark.slow
def test_each_task_reports_to_its_own_observer_in_order() -> None:
    first, second = Listener(), Listener()
    assert run_side_by_side([succeed, succeed], [first, second], LocalProcesses(2)) == ["done", "done"]
    assert first.stages == second.stages == ["preparing"]
    assert first.cycles == second.cycles == [0.0, 1.0, 2.0, 3.0, 4.0]


@pytest.mark.slow
def test_an_error_is_raised_after_the_others_have_come_to_their_end() -> None:
    first, second = Listener(), Listener()
    with pytest.raises(SolverError, match="did not converge"):
        run_side_by_side([fail, succeed], [first, second], LocalProcesses(1))
    assert first.stages == ["failing"]
    assert second.cycles[-1] == 4.0

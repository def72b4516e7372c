"""Tasks of a batch in processes of their own."""

import operator
import time
from functools import partial

import pytest

from wirewear.blind.workers import finished_tasks


@pytest.mark.slow
def test_every_task_is_done_once_until_one_fails() -> None:
    tasks = [partial(operator.truediv, 1.0, number) for number in (1.0, 2.0, 0.0)]
    done: list[int] = []
    with pytest.raises(ZeroDivisionError):
        done.extend(finished_tasks(tasks, 1))
    assert done == [0, 1]


def test_no_task_is_begun_when_the_time_is_up() -> None:
    assert list(finished_tasks([partial(operator.index, 1)], 1, until=time.monotonic() - 1.0)) == []  # type: ignore[list-item]

# SPDX-License-Identifier: GPL-3.0-or-later
"""Workers that help this process: order, deaths, errors, and a job that is ended early."""

import os
import threading
import time
from functools import partial

import pytest

from w2w.core.reading.helpers import helped
from w2w.core.threads import use_threads

from ...patience import HANG_S


@pytest.fixture(autouse=True)
def _three_cores():
    use_threads(3)
    yield
    use_threads(0)


def test_calls_are_shared_by_this_process_and_workers_in_order():
    with helped() as spread:
        found = [*spread(_slowly, range(30))]
    assert [number for number, _ in found] == [*range(30)]
    by_process = [pid for _, pid in found]
    assert len({*by_process}) == 3
    assert os.getpid() in by_process


def test_with_one_core_all_is_done_here():
    use_threads(1)
    with helped() as spread:
        assert {pid for _, pid in spread(_slowly, range(3))} == {os.getpid()}


def test_what_a_worker_dies_of_is_done_here():
    with helped() as spread:
        assert [*spread(partial(_die_unless_in, os.getpid()), range(12))] == [*range(12)]


def test_an_error_is_raised_where_its_result_is_due():
    with helped() as spread:
        found = spread(_reciprocal, [1, 2, 0, 4])
        assert [next(found), next(found)] == [1.0, 0.5]
        with pytest.raises(ZeroDivisionError):
            next(found)


def test_what_waits_is_not_done_once_the_job_is_ended():
    done, ended = [], threading.Event()

    def note(number):
        done.append(number)
        ended.wait(HANG_S)

    use_threads(1)
    with helped() as spread:
        spread(note, range(5))
    ended.set()
    time.sleep(0.2)
    assert len(done) <= 1


def _slowly(number):
    time.sleep(0.1)
    return number, os.getpid()


def _die_unless_in(pid, number):
    if os.getpid() != pid:
        os._exit(1)
    time.sleep(0.05)
    return number


def _reciprocal(number):
    return 1 / number

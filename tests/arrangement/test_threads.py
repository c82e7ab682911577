"""The number of threads changes nothing but the time."""

from __future__ import annotations

import os
import signal
import threading
from functools import partial
from threading import Barrier, Event

import numpy as np
import pytest

import geosurf as gs
from geosurf.arrangement import threads
from geosurf.arrangement.threads import in_turn, map_threads, spare_threads
from geosurf.errors import InputError
from tests.strategies import grid


@pytest.mark.parametrize("n", ["1", "2", "4"])
def test_tasks_come_in_their_order_and_wait_for_no_busy_thread(monkeypatch, n):
    monkeypatch.setenv("GEOSURF_THREADS", n)
    busy = threading.Event()
    with spare_threads() as spare:
        assert (spare is None) == (n == "1")
        if n == "2":  # the only other thread has work until the tasks are done
            spare.submit(busy.wait)
        assert in_turn([lambda k=k: k for k in range(5)], spare) == list(range(5))
        busy.set()


@pytest.mark.parametrize("said", ["0", "two", "-1", ""])
def test_a_number_of_threads_that_is_none(monkeypatch, said):
    monkeypatch.setenv("GEOSURF_THREADS", said)
    flat = grid("Top", np.zeros((2, 2)))
    with pytest.raises(InputError, match=r"GEOSURF_THREADS is '.*'; give a whole number above 0"):
        gs.intersect_surfaces([flat, grid("Base", np.ones((2, 2)))])


@pytest.mark.parametrize("n", ["1", "2", "4"])
def test_rows_are_done_once_and_the_first_error_is_raised(monkeypatch, n):
    """Calls in calls, too, and while all other threads are busy: nobody waits for them."""
    monkeypatch.setenv("GEOSURF_THREADS", n)
    done = []

    def inner(k):
        if k in (5, 7):
            raise ValueError(k)
        done.append(k)
        return k

    assert (
        map_threads(lambda j: map_threads(inner, [(k,) for k in range(j)]), [(4,)] * 9)
        == [[0, 1, 2, 3]] * 9
    )
    assert sorted(done) == sorted([0, 1, 2, 3] * 9)
    done.clear()
    with pytest.raises(ValueError, match="5"):
        map_threads(inner, [(k,) for k in range(9)])
    assert {0, 1, 2, 3, 4} <= set(done)


def test_an_interrupt_while_a_thread_starts_leaves_nothing_behind(monkeypatch):
    monkeypatch.setenv("GEOSURF_THREADS", "3")
    monkeypatch.setattr(threads, "_waiting", threads.Threads())
    start, hit = threading.Thread.start, []

    def interrupted(self):
        start(self)
        if not hit:
            hit.append(self)
            raise KeyboardInterrupt

    monkeypatch.setattr(threading.Thread, "start", interrupted)
    with pytest.raises(KeyboardInterrupt):
        map_threads(abs, [(-1,), (-2,), (-3,)])
    assert hit[0].daemon  # Python's end does not wait for it
    assert map_threads(abs, [(-1,), (-2,), (-3,)]) == [1, 2, 3]


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="there are no timers")
@pytest.mark.parametrize("in_turns", [False, True])
def test_an_interrupt_while_others_work_is_raised_when_they_have_ended(monkeypatch, in_turns):
    monkeypatch.setenv("GEOSURF_THREADS", "2")
    begun, enough, told, ended = Event(), Event(), [], []

    def work(k):
        if threading.current_thread() is threading.main_thread():
            begun.wait()
        else:
            begun.set()
            enough.wait(60.0)
            ended.append(k)

    def interrupt(*_):
        if len(told) < 3:  # while the other one works
            told.append(1)
            if len(told) == 3:
                enough.set()
            signal.raise_signal(signal.SIGINT)

    def asked(spare):
        if in_turns:
            return in_turn([partial(work, 0), partial(work, 1)], spare)
        return map_threads(work, [(0,), (1,)])

    signal.signal(signal.SIGALRM, interrupt)
    signal.setitimer(signal.ITIMER_REAL, 0.1, 0.05)
    try:
        with spare_threads() as spare, pytest.raises(KeyboardInterrupt):
            asked(spare)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
    assert len(ended) == 1
    assert map_threads(abs, [(-1,), (-2,)]) == [1, 2]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
@pytest.mark.filterwarnings("ignore:This process .* is multi-threaded")
def test_a_forked_process_has_threads_of_its_own(monkeypatch):
    monkeypatch.setenv("GEOSURF_THREADS", "2")
    map_threads(abs, [(1,), (2,)])
    child = os.fork()
    if child == 0:
        signal.alarm(20)  # a process that waits for threads that it has not
        together = Barrier(2)
        map_threads(lambda: together.wait(10), [(), ()])
        os._exit(0)
    assert os.waitpid(child, 0)[1] == 0

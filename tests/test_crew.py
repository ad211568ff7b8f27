"""Processes side by side: none takes another along, and they end when told."""

import multiprocessing
import os

import crew_jobs
from georibbon.cli.crew import Crew, Fallen


def came(crew, jobs, signals=(), told=lambda _ending: None):
    return dict(crew.do(jobs, signals, told))


def test_every_job_comes_back_with_its_result():
    assert came(Crew(2, crew_jobs.odd_one_out), [1, 2, 3]) == {1: 10, 2: 20, 3: 30}
    assert came(Crew(2, crew_jobs.odd_one_out), []) == {}


def test_one_that_raises_stops_no_other():
    found = came(Crew(2, crew_jobs.odd_one_out), [1, -1, 2])
    assert (found[1], found[2]) == (10, 20)
    assert not found[-1].stopped
    assert "ValueError: -1 is negative" in found[-1].message


def test_one_whose_process_dies_takes_no_other_along():
    found = came(Crew(2, crew_jobs.odd_one_out), [1, 13, 2, 3, 4])
    assert {job: found[job] for job in (1, 2, 3, 4)} == {1: 10, 2: 20, 3: 30, 4: 40}
    assert "abruptly" in found[13].message
    assert not found[13].stopped


def test_alone_it_is_known_at_once_which_process_died():
    found = came(Crew(1, crew_jobs.odd_one_out), [13, 1])
    assert "abruptly" in found[13].message
    assert found[1] == 10


def test_after_a_signal_what_runs_is_finished_and_nothing_else_begun():
    signals, endings = [], []

    def told(ending):
        endings.append(ending)
        signals[:] = [2]

    found = came(Crew(1, crew_jobs.pause), [0.5, 0.6, 0.7], signals, told)
    assert found[0.5] == 0.5
    assert found[0.6] == found[0.7] == Fallen(True, "ended before it was done")
    assert endings[-1] is True


def test_a_second_signal_ends_what_runs():
    signals = []
    told = lambda _ending: signals.append(2)  # noqa: E731 - one line is enough
    found = came(Crew(2, crew_jobs.pause), [600, 601, 602], signals, told)
    assert {one.stopped for one in found.values()} == {True}
    assert not multiprocessing.active_children()


def test_processes_calculate_with_one_thread_each_and_the_environment_is_left(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    assert came(Crew(1, crew_jobs.threads), [0]) == {0: "1"}
    assert os.environ["OMP_NUM_THREADS"] == "7"
    assert "OPENBLAS_NUM_THREADS" not in os.environ

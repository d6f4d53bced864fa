"""The end of a sweep, however it comes: nothing runs, waits or holds a thread afterwards."""

import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

import rustchain as rc
from rustchain import _rustchain

PAPER = rc.paper_drive()
RUN = {"report_step": 1e-3, "progress": False}
FAR = 1000.0  # [s], hours of wall time away


def interrupted(result):
    raise KeyboardInterrupt


def left(result):
    raise SystemExit(3)


def named_as_a_parameter(result):
    return {"duration": 1.0}


def swept(measure, cases, **keywords):
    """Sweep durations; return how the sweep ended."""
    try:
        return rc.sweep(PAPER, {"duration": cases}, measure, **RUN, **keywords).status
    except (SystemExit, rc.InvalidInput) as error:
        return type(error).__name__


ENDS = [(interrupted, "interrupted"), (left, "SystemExit"), (named_as_a_parameter, "NameTaken")]


@pytest.mark.parametrize(("measure", "end"), [*ENDS, (lambda result: 1.0, "finished")])
def test_the_compiled_pool_is_closed_at_every_end(measure, end, monkeypatch):
    """Closing it waits for its threads, which are not those of Python."""
    pools, pool = [], _rustchain.Ensemble

    class Watched:
        def __init__(self, *arguments):
            self._pool, self.closed = pool(*arguments), False
            pools.append(self)

        def __getattr__(self, name):
            return getattr(self._pool, name)

        def close(self):
            self._pool.close()
            self.closed = True

    monkeypatch.setattr(_rustchain, "Ensemble", Watched)
    others = [2e-3] if end == "finished" else [FAR, FAR]
    assert swept(measure, [1e-3, *others], threads=2) == end
    assert [each.closed for each in pools] == [True]


@pytest.mark.parametrize(("measure", "end"), ENDS)
def test_no_thread_runs_on_behind_a_sweep_whose_rows_are_looked_at(measure, end):
    before = set(threading.enumerate())
    looks = {"callback": lambda simulation: False, "threads": 2}
    assert swept(measure, [1e-3, FAR, FAR, FAR, FAR, FAR], **looks) == end
    assert set(threading.enumerate()) == before


def test_cases_that_wait_at_an_executor_are_cancelled_behind_an_interrupt():
    """The second case waits for the end of the sweep, if it has begun, and ends by itself."""
    submitted, goes_on = [], threading.Event()

    class Watched(ThreadPoolExecutor):
        def submit(self, *arguments, **keywords):
            submitted.append(super().submit(*arguments, **keywords))
            return submitted[-1]

    def callback(simulation):
        return simulation.time > 1.5e-3 and not goes_on.wait(600.0)

    with Watched(1) as executor:
        try:
            cases = [1e-3, 2e-3, 3e-3, 4e-3]
            found = swept(interrupted, cases, executor=executor, callback=callback)
            waiting = submitted[2:]
            assert found == "interrupted"
            assert all(future.cancelled() for future in waiting)
        finally:
            goes_on.set()
    assert len(waiting) == 2


def own_error(simulation):
    raise LookupError("not there")


@pytest.mark.parametrize("executor", [None, "threads"])
@pytest.mark.parametrize(
    ("axes", "keywords"),
    [
        ({"chain.material.elastic_modulus": [2e11, 1e300]}, {"duration": 5e-3}),
        ({"chain.material.elastic_modulus": [2e11, -1.0]}, {"duration": 1e-3}),
        ({"sprockets.2.center": [PAPER.sprockets[1].center, (9.0, 0.0)]}, {"duration": 1e-3}),
        ({"speed": [10.0, 11.0]}, {"duration": 1e-3, "callback": own_error}),
        ({"speed": [10.0, 11.0]}, {"duration": 1e-3, "measure": own_error}),
        ({"start": ["generated", "none"]}, {"duration": 1e-3, "callback": lambda _: False}),
    ],
    ids=["fails", "is refused", "has no layout", "callback", "measure", "no start"],
)
def test_an_error_of_a_case_holds_no_frames_with_all_that_its_run_has(axes, keywords, executor):
    with ThreadPoolExecutor(1) as pool:
        keywords = keywords | {"executor": None if executor is None else pool}
        with pytest.warns(rc.CaseWarning, match="cases failed"):
            found = rc.sweep(PAPER, axes, progress=False, **keywords)
    for error in found.errors.values():
        while error is not None:
            assert error.__traceback__ is None
            error = error.__cause__ or error.__context__


def test_a_case_of_more_rows_than_memory_has_is_refused_alone(monkeypatch):
    monkeypatch.setattr("rustchain.simulation.run._memory", lambda: 1e6)
    axes = {"report_step": [1e-3, 1e-5]}
    with pytest.warns(rc.CaseWarning, match="1 of 2 cases failed.*memory has .* for them"):
        found = rc.sweep(PAPER, axes, duration=0.01, progress=False)
    assert list(found.errors) == [1]
    assert found.errors[1].__traceback__ is None

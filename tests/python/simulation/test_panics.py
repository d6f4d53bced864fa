"""What a panic of the compiled module is to a caller in Python."""

import inspect

import pytest

import rustchain as rc
from rustchain import _rustchain, panics


class PanicException(BaseException):
    """A stand-in for PyO3's exception of this name, which no correct call raises."""


class Run:
    """An object at a simulated time."""

    time = 0.25

    def advance(self):
        raise PanicException("index out of bounds")


def test_a_panic_is_a_simulation_error_with_the_time_of_its_object():
    with pytest.raises(
        rc.SimulationError, match=r"defect of rustchain at t = 0.25.* s: index out"
    ) as e:
        panics.guarded(Run.advance)(Run())
    assert e.value.time == 0.25
    assert (e.value.step_size, e.value.contact, e.value.result) == (None, None, None)
    assert isinstance(e.value, Exception)


def test_what_else_ends_a_call_passes():
    def interrupted():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        panics.guarded(interrupted)()


def test_every_way_into_the_compiled_module_is_guarded():
    guarded = panics.guarded(len).__code__

    def is_guarded(member):
        return inspect.isfunction(member) and member.__code__ is guarded

    classes = [_rustchain.Core, _rustchain.Ensemble, _rustchain.Case]
    members = [member for name, member in vars(_rustchain).items() if callable(member)]
    for each in classes:
        members += [member for name, member in vars(each).items() if not name.startswith("__")]
    entries = [
        member.fget if isinstance(member, property) else member
        for member in members
        if not isinstance(member, type)
    ]
    assert len(entries) > 50
    assert [entry for entry in entries if not is_guarded(entry)] == []

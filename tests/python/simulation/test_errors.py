"""Exceptions, warnings and the log of the package."""

import inspect
import logging
from dataclasses import replace

import pytest

import rustchain as rc
from rustchain import errors

TYPES = [getattr(errors, name) for name in errors.__all__]


@pytest.mark.parametrize("kind", TYPES)
def test_every_exception_and_warning_has_a_base_of_the_package_and_is_exported(kind):
    assert issubclass(kind, rc.RustchainWarning if issubclass(kind, Warning) else rc.RustchainError)
    assert getattr(rc, kind.__name__) is kind
    assert inspect.getdoc(kind)


def test_the_compiled_module_raises_the_package_s_exceptions():
    with pytest.raises(rc.RustchainError, match="restitution") as caught:
        rc.Material(restitution=2.0)
    assert type(caught.value) is rc.InvalidInput
    assert isinstance(caught.value, ValueError)


def test_the_log_has_start_warning_and_end_of_a_run(caplog):
    bristles = rc.LankaraniNikravesh(friction=rc.LuGre(0.1, 0.1, stiffness=1e9))
    with caplog.at_level(logging.INFO, "rustchain"), pytest.warns(rc.RangeWarning):
        rc.Simulation(rc.paper_drive(25.0), bristles).run(duration=1e-3, progress=False)
    levels = [(record.levelname, record.message) for record in caplog.records]
    assert ("INFO", "run of 0.001 s starts") in levels
    assert any(level == "WARNING" and "stiffness" in text for level, text in levels)
    assert levels[-1][0] == "WARNING" or levels[-1] == ("INFO", "run ended after 0.001 of 0.001 s")
    assert ("INFO", "run ended after 0.001 of 0.001 s") in levels


def test_the_log_says_why_a_run_ended_early(caplog):
    def fails(simulation):
        raise ZeroDivisionError

    simulation = rc.Simulation(rc.paper_drive(25.0))
    with caplog.at_level(logging.INFO, "rustchain"), pytest.raises(ZeroDivisionError):
        simulation.run(duration=1e-3, progress=False, callback=fails)
    assert caplog.records[-1].message.endswith("of 0.001 s: ZeroDivisionError()")


def test_a_run_that_fails_has_rows_and_the_words_of_its_error():
    drive = rc.paper_drive(25.0)
    rigid = replace(drive.chain.material, elastic_modulus=1e300)
    drive = replace(drive, chain=replace(drive.chain, material=rigid))
    with pytest.raises(rc.SimulationError) as failed:
        rc.Simulation(drive).run(duration=5e-3, progress=False)
    result = failed.value.result
    assert (result.status, result.message) == ("failed", str(failed.value))
    assert len(result.time) > 1

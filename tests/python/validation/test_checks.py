"""Checks of the validation pages that no other test asserts, and the tables of those pages."""

from dataclasses import replace

import pytest

from checks import contacts, standards
from checks.check import Check, Range, exists, hold, table

GOOD = Check(
    "a length", 1.0, 1.0 + 1e-9, 1e-8, "python/validation/test_checks.py::test_a_table", "m"
)


def test_an_elastic_impact_has_hertz_s_duration_and_penetration():
    hold(contacts.hertz_impact())


@pytest.mark.parametrize("damping", contacts.FACTORS)
def test_an_impact_returns_the_effective_restitution(damping):
    hold(contacts.restitutions(damping))


def test_a_loaded_chain_is_longer_by_the_elongation_of_its_links():
    hold(contacts.elongation())


def test_teeth_have_the_dimensions_of_the_standards():
    hold(standards.tooth_dimensions())


def test_a_table_of_a_page_has_error_bound_and_test_of_each_check():
    here = "python/validation/test_checks.py"
    good = replace(GOOD, test=f"{here}::test_teeth_have_the_dimensions_of_the_standards")
    html = table(good, [[replace(good, subject="another")]])._repr_html_()
    assert html.count("1.0e-09 m") == html.count("1e-08 m") == 2
    assert "another" in html
    assert html.count("test_teeth_have_the_dimensions_of_the_standards") == 1  # of both rows
    with pytest.raises(AssertionError, match="no such tests"):
        table(replace(good, test=f"{here}::test_that_is_not_there"))


@pytest.mark.parametrize(
    "wrong",
    [
        replace(GOOD, ours=2.0),
        replace(GOOD, ours=float("nan")),
        replace(GOOD, error=1e-7),
        replace(GOOD, ours=1.1, relative=True),
        Range("a force", 3.0, 1.0, 2.0, GOOD.test, "N"),
        Range("a force", float("nan"), 1.0, 2.0, GOOD.test, "N"),
    ],
)
def test_a_check_outside_of_its_bound_is_no_row(wrong):
    with pytest.raises(AssertionError, match=wrong.subject):
        table(GOOD, wrong)


def test_only_tests_exist():
    assert exists("multibody/mechanism.rs::a_pendulum_comes_back_after_its_period")
    assert not exists("multibody/mechanism.rs::pendulum_comes_back")
    assert not exists("multibody/no_file.rs::a_pendulum_comes_back_after_its_period")

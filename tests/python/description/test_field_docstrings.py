"""Units of parameters are those of the docstrings, and missing where they are not certain."""

import pytest

from rustchain.description.docstrings import unit_of


@pytest.mark.parametrize(
    ("parameter", "unit"),
    [
        ("pretension", "N"),
        ("duration", "s"),
        ("max_step", "s"),
        ("solver.max_step", "s"),
        ("tensioner.ramp_time", "s"),
        ("sprockets.2.motion.torque", "N m"),  # over time
        ("sprockets.2.inertia", "kg m^2"),  # the second of two
        ("sprockets.1.center.2", "m"),
        ("bodies.1.velocity.3", "rad/s"),
        ("bodies.1.position", "m, m, rad"),
        ("contacts.1.law.stiffness", None),  # that of the law
        ("forces.1.stiffness", None),  # of a spring or a torsion spring
        ("joints.1.value", None),  # a length or an angle
        ("chain.material.restitution", None),
        ("sprockets.1.teeth", None),
        ("rpm", None),
        ("1", None),
        ("sprockets.1.none", None),
    ],
)
def test_a_parameter_has_the_unit_of_its_docstring(parameter, unit):
    assert unit_of(parameter) == unit

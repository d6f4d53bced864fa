"""The arrays that a result may have: group, dimensions, unit and name of each."""

from __future__ import annotations

from typing import Any, NamedTuple


class Variable(NamedTuple):
    """Description of an array of a result."""

    group: str
    dims: tuple[str, ...]  # after "time"
    units: str
    long_name: str

    def parts(self, name: str) -> list[tuple[str, Variable, Any]]:
        """Return what a dataset has of the array `name`, in which a variable has one unit.

        Each part has a name, what it is, and its place along the last axis of the array.
        """
        if name not in PARTS:
            return [(name, self, slice(None))]
        first, second = PARTS[name]
        units = self.units.split(", ")
        inside = self.dims[:-1]
        linear = self._replace(dims=(*inside, "axis"), units=units[0])
        return [
            (first, linear._replace(long_name=f"{self.long_name}: x, y"), slice(0, 2)),
            (second, self._replace(dims=inside, units=units[-1]), 2),
        ]


PARTS = {
    "positions": ("position", "angle"),
    "velocities": ("velocity", "angular_velocity"),
    "accelerations": ("acceleration", "angular_acceleration"),
    "joint_reaction": ("joint_force", "joint_torque"),
}
"""Arrays of x, y and an angle or a torque: what a dataset calls the two and the one."""

VARIABLES = {
    "hinge_force": Variable("hinges", ("hinge",), "N", "force of pin on bushing"),
    "hinge_force_vector": Variable("hinges", ("hinge", "axis"), "N", "force on the pin"),
    "hinge_penetration": Variable("hinges", ("hinge",), "m", "penetration of pin into bushing"),
    "hinge_eccentricity": Variable(
        "hinges", ("hinge", "axis"), "m", "pin centre seen from the bushing"
    ),
    "hinge_onset_speed": Variable(
        "hinges", ("hinge",), "m/s", "initial impact velocity of the present contact"
    ),
    "roller_force": Variable("hinges", ("bushing",), "N", "force of bushing on roller"),
    "roller_force_vector": Variable(
        "hinges", ("bushing", "axis"), "N", "force of the bushing on the roller"
    ),
    "roller_penetration": Variable(
        "hinges", ("bushing",), "m", "penetration of bushing into roller"
    ),
    "roller_eccentricity": Variable(
        "hinges", ("bushing", "axis"), "m", "bushing's centre seen from the roller"
    ),
    "roller_onset_speed": Variable(
        "hinges", ("bushing",), "m/s", "initial impact velocity of the present contact"
    ),
    "peak_roller_force": Variable(
        "hinges", ("bushing",), "N", "largest force of bushing on roller since the last row"
    ),
    "peak_roller_impulse": Variable(
        "hinges", ("bushing",), "N s", "impulse of the bushing on the roller since the last row"
    ),
    "strand_tension": Variable("hinges", ("strand",), "N", "mean tension of the strand's hinges"),
    "peak_hinge_force": Variable(
        "hinges", ("hinge",), "N", "largest hinge force since the last row"
    ),
    "peak_hinge_impulse": Variable(
        "hinges", ("hinge",), "N s", "impulse of the hinge since the last row"
    ),
    "end_force": Variable("hinges", ("end", "axis"), "N", "force of the chain on its end"),
    "end_position": Variable("hinges", ("end", "axis"), "m", "pin at the chain's end"),
    "end_velocity": Variable("hinges", ("end", "axis"), "m/s", "its velocity"),
    "hinge_film_force": Variable("hinges", ("hinge",), "N", "size of the film's force on the pin"),
    "tooth_force": Variable("teeth", ("bushing",), "N", "force of tooth on bushing"),
    "tooth_force_vector": Variable(
        "teeth", ("bushing", "axis"), "N", "force of the tooth on the bushing"
    ),
    "tooth_penetration": Variable("teeth", ("bushing",), "m", "penetration of bushing into tooth"),
    "tooth_onset_speed": Variable(
        "teeth", ("bushing",), "m/s", "initial impact velocity of the present contact"
    ),
    "tooth_sprocket": Variable("teeth", ("bushing",), "1", "sprocket in contact, 0: none"),
    "tooth_index": Variable("teeth", ("bushing",), "1", "tooth gap in contact, -1: none"),
    "tooth_region": Variable("teeth", ("bushing",), "1", "region of the tooth in contact, 0: none"),
    "peak_tooth_force": Variable(
        "teeth", ("bushing",), "N", "largest tooth force since the last row"
    ),
    "peak_tooth_impulse": Variable(
        "teeth", ("bushing",), "N s", "impulse of the tooth since the last row"
    ),
    "sprocket_angle": Variable("sprockets", ("sprocket",), "rad", "angle of the sprocket"),
    "sprocket_speed": Variable("sprockets", ("sprocket",), "rad/s", "speed of the sprocket"),
    "sprocket_torque": Variable(
        "sprockets", ("sprocket",), "N m", "torque on the sprocket's shaft"
    ),
    "sprocket_center": Variable("sprockets", ("sprocket", "axis"), "m", "centre of the sprocket"),
    "positions": Variable("bodies", ("body", "coordinate"), "m, m, rad", "positions of the bodies"),
    "velocities": Variable(
        "bodies", ("body", "coordinate"), "m/s, m/s, rad/s", "velocities of the bodies"
    ),
    "accelerations": Variable(
        "bodies", ("body", "coordinate"), "m/s^2, m/s^2, rad/s^2", "accelerations of the bodies"
    ),
    "joint_reaction": Variable(
        "joints", ("joint", "component"), "N, N, N m", "force and torque on body b, about its point"
    ),
    # The largest of all equations of a joint, lengths and angles: a number of m or of rad.
    "joint_position_residual": Variable(
        "joints", ("joint",), "1", "constraint residual, over 1 m or 1 rad"
    ),
    "joint_velocity_residual": Variable(
        "joints", ("joint",), "1", "rate of the constraint residual, over 1 m/s or 1 rad/s"
    ),
    "peak_joint_force": Variable("joints", ("joint",), "N", "largest force since the last row"),
    "peak_joint_impulse": Variable("joints", ("joint",), "N s", "impulse since the last row"),
    "contact_force": Variable(
        "contacts", ("contact",), "N", "size of the contact force, friction and film included"
    ),
    "contact_force_vector": Variable("contacts", ("contact", "axis"), "N", "force on the circle"),
    "contact_impact_velocity": Variable(
        "contacts",
        ("contact",),
        "m/s",
        "largest penetration rate at the onsets since the last row, also below min_impact_velocity;"
        " 0: no onset",
    ),
    "contact_penetration": Variable("contacts", ("contact",), "m", "penetration"),
    "contact_gap": Variable("contacts", ("contact",), "1", "gap of teeth near, -1: none"),
    "contact_region": Variable("contacts", ("contact",), "1", "region of tooth near, 0: none"),
    "peak_contact_force": Variable(
        "contacts", ("contact",), "N", "largest contact force since the last row"
    ),
    "peak_contact_impulse": Variable("contacts", ("contact",), "N s", "impulse since the last row"),
    "energy_kinetic": Variable("energy", (), "J", "kinetic energy"),
    "energy_gravity": Variable("energy", (), "J", "potential energy of gravity"),
    "energy_elastic": Variable("energy", (), "J", "elastic energy of contacts and springs"),
    "energy_dissipated": Variable("energy", (), "J", "energy dissipated since the first row"),
    "energy_external_work": Variable("energy", (), "J", "external work since the first row"),
    "energy_residual": Variable("energy", (), "J", "residual of the energy balance"),
    "energy_hinge_contact": Variable("energy", (), "J", "dissipated by damping in hinges"),
    "energy_tooth_contact": Variable("energy", (), "J", "dissipated by damping on teeth"),
    "energy_hinge_friction": Variable("energy", (), "J", "dissipated by friction in hinges"),
    "energy_tooth_friction": Variable("energy", (), "J", "dissipated by friction on teeth"),
    "energy_roller_contact": Variable("energy", (), "J", "dissipated by damping in rollers"),
    "energy_roller_friction": Variable("energy", (), "J", "dissipated by friction in rollers"),
    "energy_hinge_film": Variable("energy", (), "J", "dissipated by lubricant in hinges"),
}

OF_MECHANISMS = ("joints", "contacts")
"""Groups that mechanisms alone have."""
OF_DRIVES = ("hinges", "teeth", "sprockets")
"""Groups that drives alone have."""

"""Runs whose rows are written in several pieces, of each kind of scene."""

import rustchain as rc

ALL_OF_A_DRIVE = ("hinges", "teeth", "sprockets", "bodies", "energy")
PIECE = "10 MB"  # of the rows of the paper's drive: 256 rows at once


def pendulum():
    mechanism = rc.Mechanism(name="pendulum")
    mechanism.add_body("bar", 1.0, 0.1, position=(0.5, 0.0, 0.0))
    mechanism.add_revolute("pin", "ground", "bar", point_b=(-0.5, 0.0))
    return mechanism


SCENES = {
    "clearance": lambda: rc.Simulation(rc.paper_drive(25.0)),
    "ideal": lambda: rc.Simulation(rc.paper_drive(25.0, hinges="ideal")),
    "mechanism": lambda: rc.Simulation(pendulum()),
}
RUNS = {
    "clearance": {"duration": 0.03, "report_step": 4e-5, "record": ALL_OF_A_DRIVE},
    "ideal": {"duration": 3e-3, "report_step": 1e-5, "record": ALL_OF_A_DRIVE},
    "mechanism": {"duration": 0.3, "report_step": 1e-4},
}
LITTLE = {"clearance": PIECE, "ideal": "2 MB", "mechanism": "100 kB"}

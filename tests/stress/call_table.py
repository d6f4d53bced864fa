"""Every public callable with arguments that it accepts, for `calls` to replace some of them."""

from __future__ import annotations

import functools
import inspect
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from scipy import stats

import rustchain as rc
from bad_input.fields import GOOD
from rustchain.plot import Plots, draw_loss_map
from rustchain.plot.mechanism import MechanismFigures

_LAW = rc.LinearContact(1e6)
_GROUND = {"body_a": "ground", "body_b": "a"}
_PAIR = {"body_a": "a", "body_b": "b"}
_SHORT = {"duration": 2e-4, "report_step": 1e-4, "progress": False}

# Parts of mechanisms, which are checked when the mechanism is put together.
_MECHANISM_PARTS: dict[type, dict[str, Any]] = {
    rc.SmoothStep: {"start": 0.0, "end": 1.0, "before": 0.0, "after": 1.0},
    rc.Table: {"rows": [(0.0, 1.0), (1.0, 2.0)]},
    rc.Spline: {"rows": [(0.0, 1.0), (1.0, 2.0), (2.0, 0.0)]},
    rc.Sines: {"terms": [(1.0, 2.0, 0.0)], "offset": 0.0},
    rc.LinearContact: {"stiffness": 1e6, "damping": 0.0, "length": 0.01},
    rc.HuntCrossley: {"stiffness": 1e8, "exponent": 1.5, "damping": 0.1},
    rc.SurfaceContact: {
        "law": rc.Hertz(),
        "length": 0.01,
        "material": rc.Material(),
        "min_impact_velocity": 1e-3,
    },
}

# Arguments of `Mechanism`'s methods that put bodies, joints, forces and contacts in.
_ADDED: dict[str, dict[str, Any]] = {
    "add_body": {
        "name": "c",
        "mass": 1.0,
        "inertia": 1e-3,
        "position": (1.0, 0.0, 0.0),
        "velocity": (0.0, 0.0, 0.0),
        "fixed": False,
    },
    "add_revolute": {**_GROUND, "point_a": (0.0, 0.0), "point_b": (0.0, 0.0), "at": None},
    "add_fixed": {**_GROUND, "at": (0.0, 0.0), "angle": 0.0},
    "add_prismatic": {**_GROUND, "direction": (1.0, 0.0), "at": (0.0, 0.0), "angle": 0.0},
    "add_point_on_line": {**_GROUND, "direction": (1.0, 0.0), "at": (0.0, 0.0)},
    "add_distance": {**_PAIR, "point_a": (0.0, 0.0), "point_b": (0.0, 0.0), "length": 0.5},
    "add_gear": {**_PAIR, "ratio": -2.0, "carrier": None},
    "add_rack": {**_GROUND, "direction": (1.0, 0.0), "radius": 0.1, "point_a": (0.0, 0.0)},
    "add_driver": {**_GROUND, "angle": None, "speed": 1.0},
    "add_position_driver": {**_GROUND, "direction": (1.0, 0.0), "position": None, "speed": 1.0},
    "add_force": {"body": "a", "force": (0.0, 1.0), "point": (0.0, 0.0), "follows": False},
    "add_torque": {"body": "a", "torque": 1.0, "by_speed": None, "reaction": "ground"},
    "add_spring": {
        **_PAIR,
        "stiffness": 1e3,
        "damping": 1.0,
        "point_a": (0.0, 0.0),
        "point_b": (0.0, 0.0),
        "rest_length": 0.4,
        "cubic": 0.0,
        "table": None,
    },
    "add_torsion_spring": {**_PAIR, "stiffness": 1.0, "rest_angle": 0.0, "table": None},
    "add_callable": {"body": "a", "function": lambda *_: (0.0, 0.0, 0.0)},
    "add_clearance_joint": {
        "bore": "a",
        "pin": "b",
        "bore_radius": 0.6,
        "pin_radius": 0.01,
        "law": _LAW,
        "bore_point": (0.0, 0.0),
        "pin_point": (0.0, 0.0),
    },
    "add_disc_contact": {**_PAIR, "radius_a": 0.1, "radius_b": 0.1, "law": _LAW},
    "add_outline_contact": {
        "outline": "ground",
        "circle": "a",
        "points": [(-1.0, -1.0), (1.0, -1.0), (0.0, -0.5)],
        "radius": 0.1,
        "law": _LAW,
        "circle_point": (0.0, 0.0),
        "bulges": [0.0, 0.0, 0.0],
        "closed": True,
    },
    "add_sprocket_contact": {
        "wheel": "a",
        "circle": "b",
        "sprocket": rc.Sprocket(17),
        "chain": rc.catalogue_chain("ANSI 40", 38),
        "law": rc.SurfaceContact(),
    },
}

# What is handed out, not made by a user; and files, which tests of their own damage.
RECORDS = {
    "ChainSize",
    "DriveReport",
    "Evaluation",
    "MechanismReport",
    "Result",
    "StudyResult",
    "SweepResult",
}
FILES = {
    "export_fmu",
    "load_result",
    "load_sweep",
    "load_scene",
    "save_scene",
    "load_state",
    "save",
    "save_state",
    "from_json",
    "report",
}
_ABSTRACT = {"ForceLaw", "StopCondition"}
_ERRORS = {
    "CaseWarning",
    "EnergyWarning",
    "MissingExtra",
    "RustchainError",
    "RustchainWarning",
    "InvalidInput",
    "NoSuchPart",
    "NotRecorded",
    "RangeWarning",
    "SimulationError",
    "ToothJumpWarning",
}


@dataclass(frozen=True)
class Target:
    """A callable under its public name, and arguments that it accepts."""

    name: str
    call: Callable[..., object]
    arguments: dict[str, Any]
    annotations: dict[str, str]


class Scenes:
    """A drive, a mechanism and what their runs gave, made once."""

    def __init__(self) -> None:
        self.folder = tempfile.TemporaryDirectory()  # removed with this object
        idler = rc.SmoothIdler(0.02, (0.05, -0.2))
        self.drive = rc.chain_drive(
            "ANSI 40",
            [rc.Sprocket(17, (0, 0), rc.PrescribedSpeed(20.0)), rc.Sprocket(17, (0.15, 0))],
            adjust=2,
            guides=[idler],
            rollers="bodies",
        )
        record = ("hinges", "teeth", "sprockets", "bodies", "energy")
        self.simulation = rc.Simulation(
            self.drive, force_law=rc.LankaraniNikravesh(friction=rc.Coulomb(0.1))
        )
        self.result = self.simulation.run(2e-3, record=record, progress=False)
        ends = (rc.AnchoredEnd((0.0, 0.0)), rc.FreeEnd())
        hanging = rc.Simulation(rc.open_chain("ANSI 40", ends, 8))
        self.open_result = hanging.run(2e-4, progress=False)
        self.free = rc.Simulation(rc.two_sprocket_drive(torque=-1.0, links=60))
        self.mechanism_simulation = rc.Simulation(self.mechanism(joined=True))
        self.mechanism_result = self.mechanism_simulation.run(2e-3, progress=False)
        self.study = rc.study(
            rc.paper_drive(),
            lambda result: result.time[-1],
            runs=2,
            duration=2e-4,
            burn_in=0.0,
            progress=False,
        )
        self.losses = rc.loss_map(
            self.drive, [10.0], [0.0], duration=4e-4, burn_in=0.0, progress=False
        )

    @staticmethod
    def mechanism(*, joined: bool = False) -> rc.Mechanism:
        """Return two bodies, with joints where they are wanted."""
        mechanism = rc.Mechanism()
        mechanism.add_body("a", 1.0, 1e-2)
        mechanism.add_body("b", 1.0, 1e-2, (0.5, 0.0, 0.0))
        if joined:
            mechanism.add_revolute("pin", "ground", "a", at=(0.0, 0.1))
            mechanism.add_spring("spring", "a", "b", stiffness=10.0)
            mechanism.add_disc_contact("discs", "a", "b", 0.1, 0.1, _LAW)
            mechanism.add_torque("motor", "a", torque=0.1)
            mechanism.add_driver("turn", "ground", "b", speed=1.0)
        return mechanism


@functools.cache
def scenes() -> Scenes:
    """Return the scenes that all targets share."""
    return Scenes()


def targets() -> list[Target]:
    """Return every public callable."""
    return [
        *_descriptions(),
        *_functions(),
        *_simulations(),
        *_mechanisms(),
        *_outputs(),
        *_figures(),
    ]


@functools.cache
def targets_once() -> list[Target]:
    """Return every public callable, made once."""
    return targets()


def _target(name: str, call: Callable[..., object], described: Any, /, **arguments: Any) -> Target:
    """Return the target of a call whose signature `described` has."""
    parameters = inspect.signature(described).parameters.values()
    return Target(name, call, arguments, {p.name: str(p.annotation) for p in parameters})


def _descriptions() -> Iterator[Target]:
    good: dict[type, dict[str, Any]] = {
        type(each): {field.name: getattr(each, field.name) for field in fields(each)}
        for each in GOOD.values()
    }
    for kind, arguments in (good | _MECHANISM_PARTS).items():
        yield _target(kind.__name__, kind, kind, **arguments)
    for kind in (rc.JointForceAbove, rc.ContactForceAbove):
        part = "joint" if kind is rc.JointForceAbove else "contact"
        yield _target(kind.__name__, kind, kind, **{"force": 1.0, part: None})
    law, film = rc.Hertz(), rc.LubricantFilm(0.1)
    size = {"radii": (2.2e-3, 2.245e-3), "length": 0.011}
    pressed = {"penetration": 1e-6, **size, "surfaces": "internal", "material": None}
    yield _target("Hertz.elastic_force", law.elastic_force, law.elastic_force, **pressed)
    moved = {"eccentricity": 1e-5, "velocity": (1e-3, 0.0), **size}
    yield _target("LubricantFilm.force", film.force, film.force, **moved)
    chain, rail = GOOD["Chain"], GOOD["GuideRail"]
    for each, given in (
        (GOOD["Sprocket"], {"chain": chain}),
        (rail, {}),
        (GOOD["SmoothIdler"], {}),
    ):
        name = f"{type(each).__name__}.outline"
        yield _target(name, each.outline, each.outline, points=5, **given)
    drive = GOOD["ChainDrive"]
    yield _target(
        "ChainDrive.to_mechanism",
        drive.to_mechanism,
        drive.to_mechanism,
        hinges="ideal",
        force_law=None,
        min_impact_velocity=1e-3,
    )
    yield _target("DriveReport.of", rc.DriveReport.of, rc.DriveReport.of, drive=drive)


def _functions() -> Iterator[Target]:
    sprockets = [rc.Sprocket(17, (0, 0), rc.PrescribedSpeed(20.0)), rc.Sprocket(17, (0.15, 0))]
    chain = {"gravity": (0.0, -9.81), "rollers": "fixed", "plates": "rigid"}
    run = {**_SHORT, "threads": 1}
    more = {
        "record": ("hinges",),
        "energy": False,
        "stop": (),
        "callback": None,
    }
    where: dict[str, Any] = {"executor": None, "store": None, "retry": False}
    paper = rc.paper_drive()
    table: list[tuple[Callable[..., object], dict[str, Any]]] = [
        (rc.chain_sizes, {}),
        (rc.instruction_set, {}),
        (rc.catalogue_chain, {"name": "ANSI 40", "links": 38, "strands": 1, "rollers": "fixed"}),
        (rc.paper_drive, {"pretension": 1.0, "hinges": "clearance", "rollers": "fixed"}),
        (
            rc.two_sprocket_drive,
            {
                "chain": "ANSI 40",
                "teeth": (17, 25),
                "links": 60,
                "center_distance": None,
                "speed": 1.0,
                "pretension": 1.0,
                "torque": 1.0,
                "seat": "bottom-diameter",
                "profile": None,
                **chain,
            },
        ),
        (
            rc.chain_drive,
            {
                "chain": "ANSI 40",
                "sprockets": sprockets,
                "links": 40,
                "adjust": 2,
                "direction": (1.0, 0.0),
                "reach": 1.0,
                "tensioner": None,
                "name": "x",
                "guides": (),
                **chain,
            },
        ),
        (
            rc.open_chain,
            {
                "chain": "ANSI 40",
                "ends": (rc.AnchoredEnd((0.0, 0.0)), rc.FreeEnd()),
                "links": 8,
                "sprockets": (),
                "guides": (),
                **chain,
            },
        ),
        (rc.rpm, {"speed": 1.0}),
        (rc.effective_restitution, {"damping": "flores", "restitution": 0.5}),
        (
            rc.samples,
            {
                "distributions": {"speed": stats.norm()},
                "count": 2,
                "seed": 1,
                "method": "sobol",
            },
        ),
        (
            rc.sweep,
            {
                "scene": paper,
                "axes": {"pretension": [1.0]},
                "measure": None,
                **run,
                **more,
                **where,
            },
        ),
        (
            rc.study,
            {
                "scene": paper,
                "measure": lambda result: result.time[-1],
                "runs": 2,
                "burn_in": 0.0,
                "confidence": 0.9,
                "axes": None,
                **run,
                **more,
                **where,
            },
        ),
        (
            rc.loss_map,
            {
                "scene": paper,
                "speeds": [10.0],
                "torques": [0.0],
                "loaded": 2,
                "burn_in": 0.0,
                **run,
                **where,
            },
        ),
        (draw_loss_map, {"losses": scenes().losses}),
    ]
    for function, arguments in table:
        known = inspect.signature(function).parameters
        given = {name: value for name, value in arguments.items() if name in known}
        yield _target(function.__name__, function, function, **given)


def _simulations() -> Iterator[Target]:
    shared = scenes()
    paper = rc.paper_drive()
    start = rc.Simulation(paper)
    run = {**_SHORT, "record": ("hinges",), "energy": False, "stop": (), "callback": None}
    for name, simulation in (("Simulation", shared.simulation), ("free", shared.free)):
        if name == "Simulation":
            state = {"state": simulation.state()}
            yield _target(
                "Simulation.set_state", simulation.set_state, simulation.set_state, **state
            )
            yield _target("Simulation.run", simulation.run, simulation.run, **run)
            to_file = functools.partial(simulation.run, out=Path(shared.folder.name) / "run.nc")
            yield _target(
                "Simulation.run to a file", to_file, simulation.run, **run, memory="20 MB"
            )
            place = {"positions": simulation.positions, "velocities": simulation.velocities}
            yield _target(
                "Simulation.evaluate", simulation.evaluate, simulation.evaluate, **place, time=0.0
            )
            step = lambda t: rc.Simulation(paper).step_to(t)  # noqa: E731
            yield _target("Simulation.step_to", step, simulation.step_to, t=1e-5)
            speed = {"part": 1, "speed": 20.0}
            yield _target(
                "Simulation.set_speed", simulation.set_speed, simulation.set_speed, **speed
            )
        else:
            torque = {"part": 2, "torque": 1.0}
            call = simulation.set_torque
            yield _target("Simulation.set_torque", call, call, **torque)
            pulled = rc.Simulation(rc.paper_drive(25.0)).set_tensioner_force
            yield _target("Simulation.set_tensioner_force", pulled, pulled, force=10.0)
    made = {
        "scene": paper,
        "force_law": rc.Hertz(),
        "hinge_law": None,
        "tooth_law": None,
        "min_impact_velocity": 1e-3,
        "positions": start.positions,
        "velocities": start.velocities,
        "solver": rc.Solver(),
        "start": "generated",
    }
    yield _target("Simulation", rc.Simulation, rc.Simulation, **made)
    made["system"] = made.pop("scene")
    yield _target("Scene", rc.Scene, rc.Scene, **made)


def _mechanisms() -> Iterator[Target]:
    shared = scenes()
    yield _target("Mechanism", rc.Mechanism, rc.Mechanism, gravity=(0.0, -9.81), name="x")
    for method, arguments in _ADDED.items():

        def added(*, method: str = method, **given: Any) -> object:
            mechanism = shared.mechanism()
            getattr(mechanism, method)(**given)
            return mechanism.check()

        name = {} if "name" in arguments else {"name": "part"}
        described = getattr(rc.Mechanism, method)
        yield _target(f"Mechanism.{method}", added, described, **name, **arguments)
    for kind, arguments in _MECHANISM_PARTS.items():

        def checked(*, kind: type = kind, **given: Any) -> object:
            mechanism, part = shared.mechanism(), kind(**given)
            if kind in (rc.LinearContact, rc.HuntCrossley, rc.SurfaceContact):
                mechanism.add_disc_contact("discs", "a", "b", 0.1, 0.1, part)
            else:
                mechanism.add_torque("motor", "a", part)
            return mechanism.check()

        yield _target(f"{kind.__name__} in a mechanism", checked, kind, **arguments)
    simulation = shared.mechanism_simulation
    made = {"scene": shared.mechanism(), "solver": rc.Solver()}
    yield _target("Simulation of a mechanism", rc.Simulation, rc.Simulation, **made)
    run = {**_SHORT, "record": ("joints",), "energy": False, "stop": (), "callback": None}
    place = {"positions": simulation.positions, "velocities": simulation.velocities, "time": 0.0}
    step = lambda t: rc.Simulation(shared.mechanism()).step_to(t)  # noqa: E731
    fresh = lambda: rc.Simulation(shared.mechanism(joined=True))  # noqa: E731
    for name, call, given in (
        ("set_speed", lambda **g: fresh().set_speed(**g), {"part": "turn", "speed": 2.0}),
        ("set_torque", lambda **g: fresh().set_torque(**g), {"part": "motor", "torque": 2.0}),
        ("run", simulation.run, run),
        ("evaluate", simulation.evaluate, place),
        ("set_state", simulation.set_state, {"state": simulation.state()}),
        ("step_to", step, {"t": 1e-5}),
    ):
        described = getattr(simulation, name)
        yield _target(f"Simulation of a mechanism, {name}", call, described, **given)


# Arguments of a result's methods and figures; `start` and `end` are given to all that have them.
_NAMED: dict[str, Any] = {
    "quantiles": (0.5, 0.9),
    "bins_per_pitch": 4,
    "sprocket": 1,
    "guide": 1,
    "contact": "hinge",
    "bins": 10,
    "within": 0.5,
    "driven": 2,
    "driver": 1,
    "strand": 1,
    "stations": (0.5,),
    "modes": 2,
    "segment": None,
    "number": 1,
    "numbers": 6,
    "after": 0.0,
    "name": "strand_tension",
    "hinge": 1,
    "bushing": 1,
    "joints": "pin",
    "time": None,
    "body": "a",
    "bodies": ("a",),
    "contacts": "discs",
    "start": None,
    "end": None,
}


_PARTS = {"body": "a", "joint": "pin", "contact": "discs"}


def _methods(owner: str, of: Any, names: Iterator[str] | list[str]) -> Iterator[Target]:
    """Yield the methods of an object, with arguments by their names."""
    for name in names:
        method = getattr(of, name)
        parameters = inspect.signature(method).parameters
        given = {p.name: _NAMED[p.name] for p in parameters.values() if p.name in _NAMED}
        if name in _PARTS:
            given["name"] = _PARTS[name]
            if owner == "Result":
                given["name"] = "link_1"
        if name == "pressure_cycles":
            given["contact"] = "tooth"
        if name == "strand":
            given["name"] = "upper"
        given = {key: value for key, value in given.items() if key in parameters}
        variadic = {p.name for p in parameters.values() if p.kind is p.VAR_POSITIONAL}

        def call(*, method: Any = method, variadic: set[str] = variadic, **kept: Any) -> object:
            more = [kept.pop(name) for name in variadic if name in kept]
            first = next(iter(inspect.signature(method).parameters), None)
            lead = [kept.pop(first)] if more and first in kept else []
            return method(*lead, *more, **kept)

        yield _target(f"{owner}.{name}", call, method, **given)


def _public(kind: type) -> list[str]:
    return [
        name
        for name in dir(kind)
        if not name.startswith("_")
        and inspect.isfunction(inspect.getattr_static(kind, name))
        and name not in FILES
    ]


def _outputs() -> Iterator[Target]:
    shared = scenes()
    of_drives = [name for name in _public(rc.Result) if name not in ("joint", "contact")]
    yield from _methods("Result", shared.result, of_drives)
    yield from _methods("Result of an open chain", shared.open_result, ["end"])
    yield from _methods("Result of a mechanism", shared.mechanism_result, [*_PARTS])


def _figures() -> Iterator[Target]:
    shared = scenes()
    of_parts = _public(MechanismFigures)
    of_drives = [name for name in _public(Plots) if name not in of_parts]
    yield from _methods("Plots", shared.result.plot, of_drives)
    yield from _methods("Plots of a mechanism", shared.mechanism_result.plot, of_parts)
    draw = lambda measures="value": shared.study.plot(measures)  # noqa: E731
    yield _target("StudyResult.plot", draw, draw, measures="value")


def not_called() -> set[str]:
    """Return the public names that no target calls, and that have no reason not to be called."""
    called = {target.name.split(".")[0] for target in targets()}
    return set(rc.__all__) - called - RECORDS - FILES - _ABSTRACT - _ERRORS

"""Export of a drive as an FMU: scene, library and model description in one archive."""

from __future__ import annotations

import io
import platform
import re
import sys
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal

from rustchain import _rustchain
from rustchain.arguments import checked
from rustchain.description.drive import ChainDrive
from rustchain.description.scene import Scene, scene_of
from rustchain.errors import InvalidInput, MissingExtra
from rustchain.fmi.model_description import Model, model_description
from rustchain.fmi.variables import Input, Output, Variable, chosen, inputs_of, outputs_of
from rustchain.paths import check_writable, path_of, shown_path, write_whole
from rustchain.simulation.simulation import Simulation
from rustchain.typing import FilePath

_PLATFORMS = {
    ("linux", "x86_64"): ("linux64", "x86_64-linux"),
    ("linux", "aarch64"): ("aarch64-linux", "aarch64-linux"),
    ("darwin", "x86_64"): ("darwin64", "x86_64-darwin"),
    ("darwin", "arm64"): ("darwin64", "aarch64-darwin"),
    ("win32", "amd64"): ("win64", "x86_64-windows"),
}
"""Folder of the library in an FMU of FMI 2.0 and of 3.0, by system and machine."""

_ENDINGS = {"linux": ".so", "darwin": ".dylib", "win32": ".dll"}
_DATE = (1980, 1, 1, 0, 0, 0)  # of all files, so that equal scenes make equal FMUs


@checked
def export_fmu(
    system: ChainDrive | Scene | Simulation,
    path: FilePath,
    *,
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
    version: Literal["2.0", "3.0"] = "2.0",
) -> None:
    """Write a drive as an FMU for co-simulation.

    The FMU has the library of the present operating system; it needs neither Python nor rustchain.
    In a master, it gives the same bits as `Simulation.step_to` with `Simulation.set_speed`,
    `Simulation.set_torque` and `Simulation.set_tensioner_force` between its calls.

    Parameters
    ----------
    system : ChainDrive, Scene or Simulation
        What the FMU simulates. Of a simulation, the FMU begins with its present state.
    path : str or Path
        File to write, .fmu. Its name is that of the library in it.
    inputs : sequence of str, optional
        Names of inputs, by default all: ``"sprocket_1.set_speed"`` [rad/s] of a sprocket with a
        `PrescribedSpeed`, ``"sprocket_2.set_torque"`` [N m] of the others, and
        ``"tensioner.set_force"`` [N]. An input that the master never sets follows the description.
    outputs : sequence of str, optional
        Names of outputs, by default all: ``"sprocket_1.angle"`` [rad], ``"sprocket_1.speed"``
        [rad/s], ``"sprocket_1.torque"`` [N m], ``"strand_upper.tension"`` [N],
        ``"hinges.largest_force"``, ``"teeth.largest_force"`` and, where rollers are bodies,
        ``"rollers.largest_force"`` [N], each since the last communication point.
    version : {"2.0", "3.0"}
        Version of the FMI.

    Raises
    ------
    InvalidInput
        There is no such input or output, or the system is a mechanism.
    MissingExtra
        The installation has no library for FMUs.
    OSError
        The file cannot be written.
    """
    target = path_of(path)
    identifier = _identifier(target)
    scene = system.scene if isinstance(system, Simulation) else scene_of(system)
    if scene.kind == "mechanism":
        raise InvalidInput("system: is a mechanism; expected a drive")
    variables = [
        *chosen("inputs", inputs, inputs_of(scene.drive)),
        *chosen("outputs", outputs, outputs_of(scene.drive)),
    ]
    if not variables:
        raise InvalidInput("inputs, outputs: both are empty; expected at least one variable")
    library = library_path()
    check_writable(target)
    content, token, values = _packed(system, scene, variables)
    model = Model(
        name=scene.name,
        identifier=identifier,
        token=token,
        description="Chain drive with compliant contact",
        time=values[0],
        variables=variables,
        start=values[1:],
    )
    folder = _PLATFORMS[_platform()][version == "3.0"]
    files = {
        "modelDescription.xml": model_description(model, version),
        "resources/scene.bin": content,
        f"binaries/{folder}/{identifier}{library.suffix}": library.read_bytes(),
    }
    write_whole(target, _archive(files))


def _packed(
    system: ChainDrive | Scene | Simulation, scene: Scene, variables: Sequence[Variable]
) -> tuple[bytes, str, list[float]]:
    """Return the encoded scene, its token, and the values of time and variables at the start."""
    simulation = system if isinstance(system, Simulation) else Simulation(scene)
    positions, velocities = simulation._core.start()
    static = scene.start == "static"
    return _rustchain.fmu_scene(
        scene,
        positions=positions,
        velocities=velocities,
        # A static start has tooth surfaces, which a state holds.
        state=simulation.state()["snapshot"] if simulation is system or static else None,
        inputs=[(each.sprocket, each.quantity) for each in variables if isinstance(each, Input)],
        outputs=[(each.channel, each.element) for each in variables if isinstance(each, Output)],
    )


def _identifier(path: Path) -> str:
    """Return the name of a file as that of a library, which is an identifier of C."""
    if path.suffix.lower() != ".fmu":
        stem = path.stem.removeprefix(".fmu") or "drive"
        msg = f"path = {shown_path(path)}: expected the name of an FMU, {stem}.fmu"
        raise InvalidInput(msg)
    name = re.sub(r"\W", "_", path.stem, flags=re.ASCII)
    return name if name[0].isalpha() else f"fmu_{name}"


def _platform() -> tuple[str, str]:
    """Return operating system and processor."""
    return sys.platform, platform.machine().lower()


def library_path() -> Path:
    """Return the library of FMUs that belongs to this installation."""
    ending = _ENDINGS.get(sys.platform, ".so")
    library = Path(__file__).with_name(f"rustchain_fmi{ending}")
    if _platform() not in _PLATFORMS or not library.is_file():
        msg = (
            f"export_fmu: this installation has no library for FMUs ({library.name}) of "
            f"{' '.join(_platform())}; install a wheel of the package, or run make fmu in a clone"
        )
        raise MissingExtra(msg)
    return library


def _archive(files: Mapping[str, bytes]) -> bytes:
    """Return a ZIP archive of these files."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            info = zipfile.ZipInfo(name, _DATE)
            info.external_attr = 0o644 << 16  # readable by all
            archive.writestr(info, content, zipfile.ZIP_DEFLATED)
    return packed.getvalue()

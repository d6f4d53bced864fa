"""Coverage-guided fuzzing of what reads files: scenes, states and results.

Needs atheris (``pip install atheris``), which follows the branches of Python, not those of compiled
code. Each target mutates files of its own. Checksums are corrected after the mutation, so that the
readers behind them are reached. A file is read, or refused by `RustchainError` or `OSError`. Any
other exception is a defect, as are hangs, crashes and a process of more than 2 GB. Inputs of
defects are kept, and the exit status is then 1. Small inputs of different outcomes are in
tests/data/fuzz, and tests/python/files/test_fuzz_corpus.py reads them.
"""

from __future__ import annotations

import argparse
import collections
import contextlib
import hashlib
import json
import os
import re
import struct
import subprocess
import sys
import tempfile
import time
import traceback
import warnings
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType

import numpy as np

HANG, MEMORY = 300, 2000  # wall time of an input [s], on a busy machine; of the process [MB]
LONGEST = {"toml": 6000, "json": 6000, "member": 30_000, "snapshot": 30_000, "result": 60_000}
REPORT = 2.0  # of processor time between two reports [s]

rc: ModuleType  # rustchain, imported by `_inside` with its branches followed


def _drive(rc: ModuleType) -> object:
    return rc.Simulation(rc.paper_drive(25.0))


def _pendulum(rc: ModuleType) -> object:
    mechanism = rc.Mechanism(name="pendulum")
    mechanism.add_body("bar", 1.0, 0.1, position=(0.5, 0.0, 0.0))
    mechanism.add_revolute("pin", "ground", "bar", point_b=(-0.5, 0.0))
    mechanism.add_spring("spring", "ground", "bar", 3.0, 0.1, point_a=(0.0, 1.0))
    return rc.Simulation(mechanism)


# --- scenes


def text_seeds(ending: str) -> Iterator[bytes]:
    """Yield scenes as texts: drives, an open chain, mechanisms, and those of the examples."""
    import scenes

    path = Path(tempfile.mkdtemp(), f"scene{ending}")
    for make in (_drive, _pendulum):
        rc.save_scene(make(rc).scene, path)
        yield path.read_bytes()
    for seed in range(40):
        try:
            rc.save_scene(scenes.Seeded(seed).trial().scene, path)
        except rc.RustchainError:
            continue
        if path.stat().st_size < LONGEST["toml"]:
            yield path.read_bytes()
    for example in Path(__file__).parents[2].glob("examples/*.toml"):
        if ending == ".toml":
            yield example.read_bytes()


def read_text(ending: str) -> Callable[[bytes, Path], None]:
    """Return what reads a scene, and writes and reads it again."""

    def read(content: bytes, folder: Path) -> None:
        path, again = folder / f"scene{ending}", folder / f"again{ending}"
        path.write_bytes(content)
        scene = rc.load_scene(path)
        rc.save_scene(scene, again)
        if rc.load_scene(again) != scene:
            msg = "another scene after it was written"
            raise AssertionError(msg)

    return read


# --- states


def _state_members(simulation: object, folder: Path) -> dict[str, bytes]:
    """Return the members of a state file."""
    path = folder / "state.npz"
    simulation.save_state(path)
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def member_seeds() -> Iterator[bytes]:
    """Yield each member of a state file behind its number."""
    yield from _members(Path(tempfile.mkdtemp()))


def _members(folder: Path) -> Iterator[bytes]:
    for which, make in enumerate((_drive, _pendulum)):
        members = _state_members(make(rc), folder)
        for k, content in enumerate(members.values()):
            yield bytes([which, k]) + content


def read_member() -> Callable[[bytes, Path], None]:
    """Return what reads a state file, one member of which is the input."""
    folder = Path(tempfile.mkdtemp())
    wholes = [_state_members(make(rc), folder) for make in (_drive, _pendulum)]

    def read(content: bytes, folder: Path) -> None:
        if len(content) < 2:
            return
        members = dict(wholes[content[0] % 2])
        members[list(members)[content[1] % len(members)]] = content[2:]
        path = folder / "state.npz"
        with zipfile.ZipFile(path, "w") as archive:
            for name, value in members.items():
                archive.writestr(name, value)
        _goes_on(rc.Simulation.load_state(path))

    return read


def _goes_on(simulation: object) -> None:
    """Make a step or two of what was read."""
    simulation.step_to(simulation.time + 1e-7)
    if not np.isfinite(simulation.positions).all():
        msg = "positions are not finite"
        raise AssertionError(msg)


def _hash(content: bytes) -> int:
    """Return the FNV-1a hash of 64 bits."""
    value = 0xCBF29CE484222325
    for byte in content:
        value = (value ^ byte) * 0x100000001B3 & 0xFFFFFFFFFFFFFFFF
    return value


def snapshot_seeds() -> Iterator[bytes]:
    """Yield snapshots without their checksums, at the start and some steps later."""
    for which, make in enumerate((_drive, _pendulum)):
        simulation = make(rc)
        for _ in range(2):
            yield bytes([which]) + simulation.state()["snapshot"][:-8]
            simulation.step_to(2e-4)


def read_snapshot() -> Callable[[bytes, Path], None]:
    """Return what restores a snapshot with a right checksum."""
    simulations = [make(rc) for make in (_drive, _pendulum)]
    states = [simulation.state() for simulation in simulations]

    def read(content: bytes, folder: Path) -> None:
        if not content:
            return
        body = content[1:]
        which, snapshot = content[0] % 2, body + struct.pack("<Q", _hash(body))
        simulations[which].set_state(states[which] | {"snapshot": snapshot})

    return read


# --- results


def result_seeds() -> Iterator[bytes]:
    """Yield files of `Result.save`, without their checksums, and streamed ones."""
    path = Path(tempfile.mkdtemp(), "result.nc")
    for make in (_pendulum, _drive):
        groups = ("bodies", "energy")
        result = make(rc).run(2e-4, 1e-4, record=groups, progress=False)
        result.save(path)
        content = path.read_bytes()
        yield content[: content.rindex(b"\nrustchain sha256")]
    _pendulum(rc).run(2e-4, 1e-4, record=("bodies",), progress=False, out=path)
    yield path.read_bytes()


def read_result() -> Callable[[bytes, Path], None]:
    """Return what reads a result with a right checksum, and all of its arrays."""

    def read(content: bytes, folder: Path) -> None:
        path = folder / "result.nc"
        sum_of = f"\nrustchain sha256 {hashlib.sha256(content).hexdigest()}\n".encode()
        path.write_bytes(
            content if content.startswith(b"\x89HDF\r\n\x1a\n\x03") else content + sum_of
        )
        result = rc.load_result(path)
        for name in result.arrays:
            result.array(name)

    return read


TARGETS: dict[str, tuple[Callable[[], Iterator[bytes]], Callable[[], Callable]]] = {
    "toml": (lambda: text_seeds(".toml"), lambda: read_text(".toml")),
    "json": (lambda: text_seeds(".json"), lambda: read_text(".json")),
    "member": (member_seeds, read_member),
    "snapshot": (snapshot_seeds, read_snapshot),
    "result": (result_seeds, read_result),
}


def _inside(name: str, seconds: float, folder: Path) -> None:
    """Fuzz in this process, for so much processor time; the counts are in a file at the end."""
    global rc
    import atheris

    with atheris.instrument_imports(include=["rustchain", "json", "tomllib"]):
        import rustchain

        rc = rustchain
        corpus, defects = folder / "corpus", folder / "defects"
        for made in (corpus, defects):
            made.mkdir(parents=True, exist_ok=True)
        seeds = list(TARGETS[name][0]())
        read = TARGETS[name][1]()
        work = Path(tempfile.mkdtemp())
        for seed in seeds:
            with contextlib.suppress(rc.RustchainError):  # a scene that names another file
                read(seed, work)
            (corpus / hashlib.sha1(seed).hexdigest()).write_bytes(seed)
    warnings.simplefilter("ignore")
    words = {word for seed in seeds for word in re.findall(rb"[A-Za-z_]{3,30}", seed)}
    lines = (f'"{word.decode()}"' for word in sorted(words)[:2000])
    (folder / "words.dict").write_text("\n".join(lines))
    counts: collections.Counter[str] = collections.Counter()
    begin = reported = time.process_time()

    def once(content: bytes) -> None:
        nonlocal reported
        try:
            read(content, work)
            counts["read"] += 1
        except (rc.RustchainError, OSError) as error:
            panicked = "defect of rustchain" in str(error)
            counts["refused"] += 1
            if panicked:
                _keep(defects, content, error)
        except BaseException as error:
            if isinstance(error, KeyboardInterrupt):
                raise
            counts["defect"] += 1
            _keep(defects, content, error)
        now = time.process_time()
        if now - reported > REPORT:
            reported = now
            spent = {"processor time": now - begin, **counts}
            (folder / "counts.json").write_text(json.dumps(spent))
            if now - begin > seconds:
                os._exit(0)

    options = [f"-timeout={HANG}", f"-rss_limit_mb={MEMORY}", f"-max_len={LONGEST[name]}"]
    options.append(f"-report_slow_units={HANG}")  # a busy machine is no defect
    options += [
        f"-artifact_prefix={defects}/",
        f"-dict={folder / 'words.dict'}",
        "-print_final_stats=1",
    ]
    atheris.Setup([sys.argv[0], *options, str(corpus)], once)
    atheris.Fuzz()


def _keep(folder: Path, content: bytes, error: BaseException) -> None:
    """Keep the first input of each place that raises."""
    frames = traceback.extract_tb(error.__traceback__)[-3:]
    places = "-".join(f"{Path(frame.filename).stem}{frame.lineno}" for frame in frames)
    path = folder / f"{type(error).__name__}-{places}"[:120]
    if not path.exists():
        path.write_bytes(content)
        path.with_name(path.name + ".txt").write_text("".join(traceback.format_exception(error)))


def main() -> int:
    """Fuzz a target in processes of its own, which a crash ends, and say what was found."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("target", choices=TARGETS)
    parser.add_argument("--seconds", type=float, default=600.0, help="processor time")
    parser.add_argument("--folder", type=Path, required=True, help="for corpus and defects")
    parser.add_argument("--inside", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.inside:
        _inside(given.target, given.seconds, given.folder)
    total: collections.Counter[str] = collections.Counter()
    report = given.folder / "counts.json"
    given.folder.mkdir(parents=True, exist_ok=True)
    while total["processor time"] < given.seconds:
        report.unlink(missing_ok=True)
        left = given.seconds - total["processor time"]
        command = [sys.executable, __file__, given.target, "--inside", f"--seconds={left}"]
        command.append(f"--folder={given.folder}")
        # Temporary files are here, since a process that ends early does not remove its own.
        memory = "/dev/shm" if Path("/dev/shm").is_dir() else None
        with (
            (given.folder / "log").open("ab") as log,
            tempfile.TemporaryDirectory(dir=memory) as scratch,
        ):
            environment = os.environ | {"TMPDIR": scratch}
            ended = subprocess.run(command, stdout=log, stderr=log, env=environment)
        if not report.exists():
            print(f"ended with {ended.returncode} before its first report")
            return 1
        total.update(json.loads(report.read_text()))
        total["processes that ended early"] += ended.returncode != 0
    found = sorted(path.name for path in (given.folder / "defects").iterdir())
    corpus = len(list((given.folder / "corpus").iterdir()))
    print(given.target, dict(total), f"{corpus} inputs in the corpus; defects: {found}")
    return int(bool(found))


if __name__ == "__main__":
    sys.exit(main())

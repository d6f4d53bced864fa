"""Executors of the cases of a sweep, by their names on the command line."""

from __future__ import annotations

import atexit
import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated, Any

from rustchain.cli.common import misuse
from rustchain.errors import InvalidInput
from rustchain.extras import typer
from rustchain.names import suggest
from rustchain.sweeps.running import cores

_WORDS = ("threads", "processes", "loky", "dask", "mpi")

Where = Annotated[
    str,
    typer.Option(
        "--executor",
        help="Where cases run: threads, threads:4, processes:4, loky:4, dask:tcp://host:8786 or "
        "dask:scheduler.json, mpi (with mpiexec -n 5 python -m mpi4py.futures -m rustchain ...).",
        autocompletion=lambda incomplete: [word for word in _WORDS if word.startswith(incomplete)],
    ),
]


@contextmanager
def executor_of(text: str) -> Iterator[dict[str, Any]]:
    """Give the keywords ``executor`` or ``threads`` of `sweep` that a word stands for."""
    kind, _, more = text.partition(":")
    if kind not in _WORDS:
        msg = f"--executor = {text!r}: is none; {suggest(kind, _WORDS)}"
        misuse(msg)
    if kind == "dask":
        yield from _dask(more)
    elif kind == "mpi":
        with _imported("mpi4py.futures", "mpi4py").MPIPoolExecutor() as executor:
            yield {"executor": executor}
    elif kind == "threads":
        yield {"threads": _count(text, more)}
    else:
        yield from _pool(kind, _count(text, more) or cores())


def _dask(address: str) -> Iterator[dict[str, Any]]:
    """Give a client of the scheduler at an address, or whose file is named."""
    if not address:
        msg = "--executor = 'dask': has no address; expected dask:tcp://host:8786 or dask:file.json"
        misuse(msg)
    client = _imported("dask.distributed", "dask[distributed]").Client
    file = address.endswith(".json")
    keywords = {"scheduler_file": address} if file else {"address": address}
    with client(**keywords, timeout=20) as executor:
        yield {"executor": executor}


def _pool(kind: str, count: int) -> Iterator[dict[str, Any]]:
    """Give a pool of processes, which end when it is left: after Ctrl-C in the middle of a case."""
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import active_children, get_context

    if kind == "loky":
        executor, more = _imported("loky", "loky").ProcessPoolExecutor(count), {}
    else:  # not forked: threads of this process would stop in the middle of what they do
        executor = ProcessPoolExecutor(count, get_context("spawn"), _end_with_parent)
        # The sweep has cancelled what waits. The thread of the pool leaves these futures alone only
        # if it is told so, and if the executor is still there: until the exit.
        more = {"cancel_futures": True}
        atexit.register(executor.shutdown)
    try:
        yield {"executor": executor}
    finally:
        executor.shutdown(wait=False, **more)
        for child in active_children():
            child.terminate()


def _end_with_parent() -> None:
    """End this worker when its parent has ended: after a kill it would wait for cases forever."""
    from multiprocessing import parent_process
    from threading import Thread

    def wait() -> None:
        if (parent := parent_process()) is not None:
            parent.join()
        os._exit(1)

    Thread(target=wait, daemon=True).start()


def _imported(module: str, package: str) -> Any:  # noqa: ANN401
    """Import a module of a package that may be missing."""
    import importlib

    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        msg = f'--executor: {error.name} is not installed: pip install "{package}"'
        raise InvalidInput(msg) from error


def _count(text: str, given: str) -> int | None:
    """Return the number of workers; None: as many as there are cores."""
    if not given:
        return None
    if not (given.isdecimal() and int(given) >= 1):
        msg = f"--executor = {text!r}: expected a number of workers behind the colon, such as 4"
        misuse(msg)
    return int(given)

"""A map of efficiency and losses over speed and load."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from rustchain.arguments import checked, shown
from rustchain.description.drive import ChainDrive
from rustchain.description.scene import Scene, scene_of
from rustchain.description.sprocket import AppliedTorque
from rustchain.errors import InvalidInput
from rustchain.results.result import Result
from rustchain.sweeps.axes import driver_of
from rustchain.sweeps.cases import check_burn_in
from rustchain.sweeps.running import DaskClient
from rustchain.sweeps.sweep import sweep
from rustchain.typing import Count, FilePath, Number, Numbers

if TYPE_CHECKING:
    from concurrent.futures import Executor

    import xarray as xr


_LOSS = "loss of "  # before the name of a channel


@checked
def loss_map(
    scene: Scene | ChainDrive,
    speeds: Numbers,
    torques: Numbers,
    *,
    loaded: Count = 2,
    duration: Number = 0.5,
    burn_in: Number = 0.2,
    report_step: Number = 1e-4,
    threads: Count | None = None,
    executor: Executor | DaskClient | None = None,
    store: FilePath | None = None,
    retry: bool = False,
    progress: bool = True,
) -> xr.Dataset:
    """Run a drive at every speed and load, and return its efficiency and losses at each.

    Parameters
    ----------
    scene : Scene or ChainDrive
        What to simulate; one sprocket has a prescribed speed, sprocket `loaded` takes the load.
    speeds : sequence of float
        Speeds of the driver [rad/s].
    torques : sequence of float
        Torques on sprocket `loaded` [N m], against its motion: the opposite sign of its speed.
    loaded : int
        Number of the loaded sprocket, from 1.
    duration, burn_in : float
        Simulated time of each case, and how much of it at the beginning is not measured [s].
    report_step
        As in `Simulation.run`.
    threads, executor, store, retry, progress
        As in `sweep`.

    Returns
    -------
    Dataset
        Over ``speed`` and ``torque``: ``efficiency``; ``lost`` [W] in all; ``loss`` [W], also over
        ``channel``, as in `Result.power_balance`; ``delivered`` [W] by sprocket `loaded`. NaN where
        a case has failed, or did not end before Ctrl-C; ``attrs`` have ``status`` and ``message``,
        as in `SweepResult`.

    Examples
    --------
    >>> losses = rc.loss_map(
    ...     rc.paper_drive(), [10.0, 20.0], [-1.0], duration=2e-3, burn_in=1e-3, progress=False
    ... )
    >>> dict(losses["efficiency"].sizes)
    {'speed': 2, 'torque': 1}
    """
    from rustchain.extras import xarray as xr

    drive = scene_of(scene).drive
    count = len(drive.sprockets)
    if loaded not in range(1, count + 1):
        there = f"must be the number of a sprocket, 1 to {count}"
        msg = f"loaded = {shown(loaded)}: {there if count else 'the drive has no sprocket'}"
        raise InvalidInput(msg)
    check_burn_in(burn_in, duration, [{}])
    if report_step - (duration - burn_in) > 1e-9 * duration:  # rounding
        msg = (
            f"report_step = {shown(report_step)}: must be at most the time that is measured, "
            f"{duration - burn_in:g} s; take a smaller one, or a longer duration"
        )
        raise InvalidInput(msg)
    for name, values in (("speeds", speeds), ("torques", torques)):
        if len(values) == 0:
            raise InvalidInput(f"{name} = {shown(values)}: must hold at least one value")
    driver = driver_of(drive)
    if loaded == driver:
        msg = f"loaded = {loaded}: sprocket {loaded} is the driver; expected another sprocket"
        raise InvalidInput(msg)
    if driver is not None:  # without one the sweep refuses its speeds
        sides = drive.check().sides
        same = 1.0 if sides[loaded - 1] == sides[driver - 1] else -1.0
        powers = same * np.multiply.outer(np.ravel(torques), np.ravel(speeds))
        helping = np.argwhere(powers > 0.0)
        if len(helping) > 0:
            torque, speed = np.ravel(torques)[helping[0, 0]], np.ravel(speeds)[helping[0, 1]]
            msg = (
                f"torques = {torque:g} N m at speeds = {speed:g} rad/s: turns sprocket {loaded} "
                f"the way it goes, so that it drives; a load has the other sign: {-torque:g} N m"
            )
            raise InvalidInput(msg)
    motion = f"sprockets.{loaded}.motion"
    swept = sweep(
        scene,
        {"speed": speeds, motion: [AppliedTorque(torque) for torque in torques]},
        partial(_balance, loaded=loaded, burn_in=burn_in),
        duration=duration,
        report_step=report_step,
        record=("sprockets", "energy"),
        threads=threads,
        executor=executor,
        store=store,
        retry=retry,
        progress=progress,
    )
    found = swept.to_xarray()
    channels = [str(name).removeprefix(_LOSS) for name in found if str(name).startswith(_LOSS)]
    if not channels:  # no case has ended
        raise KeyboardInterrupt if swept.status == "interrupted" else swept.errors[0]
    variables = {
        name: (("speed", "torque"), found[name].to_numpy(), {"units": unit})
        for name, unit in (("efficiency", "1"), ("lost", "W"), ("delivered", "W"))
    }
    loss = np.stack([found[_LOSS + channel].to_numpy() for channel in channels], -1)
    return xr.Dataset(
        {**variables, "loss": (("speed", "torque", "channel"), loss, {"units": "W"})},
        {
            "speed": ("speed", np.asarray(speeds, dtype=float), {"units": "rad/s"}),
            "torque": ("torque", np.asarray(torques, dtype=float), {"units": "N m"}),
            "channel": channels,
        },
        found.attrs,
    )


def _balance(result: Result, *, loaded: Count, burn_in: Number) -> dict[str, float]:
    """Return efficiency, power lost, in all and by channel, and delivered [W] after the burn-in."""
    power = result.power_balance(start=burn_in)
    loss = power["loss"]
    channels = map(str, power["channel"].to_numpy())
    return {
        "efficiency": float(power["efficiency"]),
        "lost": float(loss.sum()),
        "delivered": -float(power["shaft_power"].sel(sprocket=loaded)),
        **{_LOSS + name: float(value) for name, value in zip(channels, loss, strict=True)},
    }

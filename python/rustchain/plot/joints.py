"""The figure of the loads of joints, of mechanisms and of drives whose hinges are joints."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from rustchain.analysis.window import rows_between
from rustchain.arguments import shown
from rustchain.description.ends import hinges_of
from rustchain.description.sprocket import PrescribedSpeed
from rustchain.errors import InvalidInput
from rustchain.names import suggest
from rustchain.plot.colors import BLUE, RED, color_of
from rustchain.plot.mechanism import joint_loads_figure
from rustchain.plot.style import Ax, Figures, legend_above, styled, subplots
from rustchain.typing import Time


class JointFigures(Figures):
    """The figure of the joints and drivers of a drive with ideal hinges."""

    @styled
    def joint_loads(
        self, *joints: str | Sequence[str], start: Time = None, end: Time = None, ax: Ax = None
    ) -> Figure:
        """Draw the force of ideal hinges and the torque of motors over time.

        Joints have the names "hinge_6" and "motor_1", by the numbers of `Result.hinge` and
        `Result.sprocket`, one by one or in a list. Without a name the mean and the largest force of
        all hinges are drawn, and all motors where sprockets were recorded. Of a mechanism, force
        and torque of its joints and drivers are drawn, without a name of all.
        """
        if self.result.scene.kind == "mechanism":
            return joint_loads_figure(
                self.result, joints, rows_between(self.result, start, end), ax
            )
        self._check_ideal()
        names = self._joint_names(joints)
        hinges = [name for name in names if name.startswith("hinge_")]
        recorded = self._motors() if "sprocket_torque" in self.result.arrays else []
        motors = [name for name in (names or recorded) if name.startswith("motor_")]
        rows = rows_between(self.result, start, end)
        time = self.result.time[rows]
        shown = ["force [N]"] * (not names or bool(hinges)) + ["torque [N m]"] * bool(motors)
        figure, cells = subplots(
            len(shown), 1, sharex=True, squeeze=False, ax=ax, figsize=(7.0, 0.6 + 1.8 * len(shown))
        )
        if not names:
            force = self.result.array("hinge_force")[rows][:, hinges_of(self.result.drive)]
            cells[0, 0].plot(time, force.max(axis=1), color=RED, label="largest of all hinges")
            cells[0, 0].plot(time, force.mean(axis=1), color=BLUE, label="mean of all hinges")
        for k, name in enumerate(hinges):
            force = self.result.hinge(_number(name)).force[rows]
            cells[0, 0].plot(time, force, color=color_of(k), label=name)
        for k, name in enumerate(motors):
            torque = self.result.sprocket(_number(name)).torque[rows]
            cells[-1, 0].plot(time, torque, color=color_of(k), label=name)
        for axes, label in zip(cells[:, 0], shown, strict=True):
            axes.set_ylabel(label)
            legend_above(axes)
        cells[-1, 0].set_xlabel("time [s]")
        figure.align_ylabels()
        return figure

    def _check_ideal(self) -> None:
        """Refuse a drive whose hinges have clearance."""
        hinges = self.result.drive.hinges
        if hinges != "ideal":
            msg = (
                f"ChainDrive.hinges = {shown(hinges)}: the hinges of this drive are contacts and "
                "no joints: hinge_force and hinge_loads draw them; hinges='ideal' makes joints of "
                "them"
            )
            raise InvalidInput(msg)

    def _motors(self) -> list[str]:
        """Return the names of the sprockets' drivers."""
        sprockets = enumerate(self.result.drive.sprockets, 1)
        return [f"motor_{k}" for k, one in sprockets if isinstance(one.motion, PrescribedSpeed)]

    def _joint_names(self, given: tuple[str | Sequence[str], ...]) -> list[str]:
        """Return the names that are given, which must exist."""
        hinges = [f"hinge_{k + 1}" for k in hinges_of(self.result.drive)]
        known = hinges + self._motors()
        wanted: list[str] = []
        for one in given:
            wanted += [one] if isinstance(one, str) or not isinstance(one, Sequence) else one
        for name in wanted:
            if name not in known:
                some = (hinges[0], f"... {hinges[-1]}", *self._motors())
                msg = (
                    f"joint: {shown(name)} is no joint with a load here; "
                    f"{suggest(name, known, some)}"
                )
                raise InvalidInput(msg)
        return wanted


def _number(name: str) -> int:
    """Return the number in a name such as "hinge_6"."""
    return int(name.rpartition("_")[2])

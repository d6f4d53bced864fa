"""Histories of a drive made by hand, and the drive."""

import math
from dataclasses import replace

import numpy as np

import rustchain as rc

SPEED = rc.PrescribedSpeed(12.566)
# Teeth 17, 25 and, on the outside, 13.
THREE = rc.chain_drive(
    "ANSI 40",
    [
        rc.Sprocket(17, (0.0, 0.0), SPEED),
        rc.Sprocket(25, (0.35, -0.05), rc.AppliedTorque(-2.0)),
        rc.Sprocket(13, (0.18, -0.005), side="outside"),
    ],
)


def made(run, pitches, time, **arrays):
    """Return a result whose chain has moved so many pitches; what is not given is zero.

    A pitch is 2 pi / 17 rad of the first sprocket, from the angle that puts hinge 1 on a seat. The
    others turn with it, the one on the outside backward.
    """
    rows = len(pitches)
    tooth = 2 * math.pi / np.array([17, 25, -13])
    zeros = {
        name: np.zeros((rows, *array.shape[1:]), array.dtype) for name, array in run.arrays.items()
    }
    angle = np.array(run.drive.check().phase) + np.outer(pitches, tooth)
    center = np.tile(run.array("sprocket_center")[:1], (rows, 1, 1))
    given = {"time": np.array(time), "sprocket_angle": angle, "sprocket_center": center}
    return replace(run, arrays=zeros | given | arrays)

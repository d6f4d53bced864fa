"""Compute the comparison with exudyn that docs/validation/codes.md shows, and store it.

Needs exudyn: ``pip install --group peers``. ``make validation-data`` runs it.
"""

import argparse
import datetime
import importlib.metadata
import json

import numpy as np

import ideal_drive_peer as scene
from provenance import ROOT, git

STORED = ROOT / "docs" / "validation" / "exudyn.json"
SPAN = 2e-3
STEPS = (100, 300, 900)


def compared():
    """Return errors of exudyn's steps [m], the motion [m], and from what they were computed."""
    reference, _, _ = scene.by_rustchain(1e-10, SPAN)
    errors = [float(np.max(np.abs(scene.by_exudyn(steps, SPAN)[0] - reference))) for steps in STEPS]
    moved = float(np.max(np.abs(reference - scene.link_places()[:, :2])))
    return {
        "steps": STEPS,
        "errors": errors,
        "moved": moved,
        "exudyn": importlib.metadata.version("exudyn"),
        "commit": git("rev-parse", "HEAD"),
        "date": datetime.datetime.now(datetime.timezone.utc).date().isoformat(),
    }


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    STORED.write_text(json.dumps(compared(), indent=1) + "\n", encoding="utf-8")

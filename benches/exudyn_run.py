"""Runs of exudyn as a peer: generalized-alpha, index 2, sparse, fixed steps."""

import time

import numpy as np


def solve(system, nodes, steps, span):
    """Places of `nodes` [m] after `span` [s] and processor time [s] of a complete `system`."""
    import exudyn as exu

    system.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = steps
    settings.timeIntegration.endTime = span
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.9
    settings.solutionSettings.writeSolutionToFile = False
    settings.linearSolverType = exu.LinearSolverType.EigenSparse
    begin = time.process_time()
    system.SolveDynamic(settings)
    spent = time.process_time() - begin
    position = exu.OutputVariableType.Position
    return np.array([system.GetNodeOutput(node, position)[:2] for node in nodes]), spent

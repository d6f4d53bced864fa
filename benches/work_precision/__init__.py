"""Run time against error: scenes, the own integrator, other solvers, and what is made of it."""

"""Run time against error: scenes, the own integrator, its rivals, and what is made of it."""

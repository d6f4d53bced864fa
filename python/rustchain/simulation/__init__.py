"""Simulations: start, steps, evaluations, runs, stop conditions."""

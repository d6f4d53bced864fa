"""Frozen dataclasses that describe a scene, in SI units."""

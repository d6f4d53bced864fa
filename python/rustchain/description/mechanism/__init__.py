"""Planar mechanisms described by hand."""

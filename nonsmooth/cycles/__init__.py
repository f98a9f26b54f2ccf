"""Periodic motions: found, followed along a parameter, their multipliers."""

"""Steady sliding, its stability, and the small vibration about it."""

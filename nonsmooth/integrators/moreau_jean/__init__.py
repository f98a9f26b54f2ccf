"""Moreau–Jean: a fixed step, velocities and impulses, one contact problem a step."""

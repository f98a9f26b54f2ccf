"""Scenes: bodies with shapes, and which of them touch where. Knows no solver.

``shape_rows`` holds the shapes, ``detection`` what goes in and comes out: the `Motion` of the bodies and the
contacts `Found`. ``broad_phase`` lists the pairs that may touch; ``planar`` and ``spatial`` say of each pair where, an
algorithm a file. ``mass_properties`` has mass, centroid and inertia of the shapes.
"""

"""Scenes from files of robots, MJCF and URDF: what they say as bodies, joints, limits, springs and motors."""

"""Time stepping of scenes: many bodies, their contacts found anew at each step; read ``planar_step.py`` first."""

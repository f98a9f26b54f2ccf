"""Time stepping of scenes: many bodies, their contacts found anew at each step; read ``stages.py`` first."""

"""Time stepping of scenes: many bodies, their contacts found anew at each step. ``step.py`` is the table of contents."""

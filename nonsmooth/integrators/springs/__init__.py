"""Compliant contacts of scenes: springs, dampers and sliders, resolved in time; read ``steps.py`` first."""

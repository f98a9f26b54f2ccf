"""Radau IIA of order 5 with located events: the method behind event_driven and penalty."""

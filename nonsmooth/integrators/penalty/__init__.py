"""Compliant contacts: springs and dampers, resolved in time."""

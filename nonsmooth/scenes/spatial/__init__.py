"""Contacts of spatial shapes."""

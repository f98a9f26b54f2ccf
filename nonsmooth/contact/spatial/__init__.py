"""Contacts of a System with friction in two directions."""

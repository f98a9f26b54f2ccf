"""Contacts of planar shapes: ``find_contacts`` is the entry, ``placement`` brings the shapes to where they are,
``hulls`` and ``half_plane`` are the narrow phase."""

"""Contacts with Coulomb friction: contact problem in, impulses out.

``planar`` finds every solution of a few contacts in the plane, ``blocks`` solves many, in the plane or in space;
``islands`` says which contacts are coupled at all.
"""

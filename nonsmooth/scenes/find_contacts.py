"""Contacts between the shapes of a scene: of the plane or of space, by d."""

from nonsmooth.jit import InDimensions
from nonsmooth.scenes.planar.find_contacts import find_contacts as in_plane
from nonsmooth.scenes.spatial.find_contacts import find_contacts as in_space

find_contacts = InDimensions(in_plane.function, in_plane, in_space)

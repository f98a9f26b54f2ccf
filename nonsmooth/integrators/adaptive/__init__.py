"""Moreau–Jean with error control: plain steps extrapolated in smooth motion, events found on the motion."""

"""The player: a motion as one HTML file that any browser plays offline."""

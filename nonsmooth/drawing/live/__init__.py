"""A run that is seen in a browser while it goes on, by viser."""

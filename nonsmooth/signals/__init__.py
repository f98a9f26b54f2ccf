"""What passes through a long calculation from outside: how far it is, and Ctrl-C."""

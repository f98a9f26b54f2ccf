"""From the front door to the loop: starts, blocks of steps, records, events of the user, checkpoints, failures."""

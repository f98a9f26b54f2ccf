"""What a run leaves: solution, motion between the records, failures; and its files."""

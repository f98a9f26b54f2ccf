"""One task at many points: axes, batches, workers, the journal, the tables."""

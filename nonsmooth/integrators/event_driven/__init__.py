"""Event-driven: high order between events, every event located, new modes behind it."""

"""Every figure. Matplotlib is imported when one is drawn."""

"""Which commands sound alike."""

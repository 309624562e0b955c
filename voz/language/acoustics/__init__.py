"""The acoustic model of a language, and the distances between its phones."""

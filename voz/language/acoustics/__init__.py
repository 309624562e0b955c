"""The acoustic model of a language, and how far apart it holds its phones."""

"""The formats in which users write commands, read into what sentences are."""

"""The files that are generated from a list: contents, names and checks."""

"""The files that are made from a list: their contents, names and checks."""

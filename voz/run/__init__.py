"""Puts the parts of a run together: sources, a clock, the rules and receivers."""

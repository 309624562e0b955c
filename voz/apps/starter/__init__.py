"""Begins a robot of one's own."""

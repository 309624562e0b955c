"""Hunts for ways to let a robot drive on: what `hunt.py` does, and to what."""

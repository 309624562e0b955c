"""Decodes recordings by the thousand and the million, with many workers, and loses nothing.

inputs ─▶ scheduler ─▶ executor: workers ─▶ journal ─▶ output
"""

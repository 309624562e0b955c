"""Recordings by the thousand and the million: handed out, decoded by many, and nothing lost.

inputs ─▶ scheduler ─▶ pool of workers ─▶ journal ─▶ output
▲               │
└── tried again ┘
"""

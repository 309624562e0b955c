"""Compiles templates to commands."""

"""Parsers for the formats in which users write commands."""

"""Pronunciations of words: dictionaries, compounds, rules and guesses."""

"""How words are pronounced: dictionaries, compounds, rules and guesses."""

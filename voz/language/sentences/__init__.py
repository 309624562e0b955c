"""Sentences: templates, the automaton of all sentences, and their meanings."""

"""What sentences are: templates, the automaton that holds all sentences, what they mean."""

"""Sentence templates: from a file that says many sentences at once to what tells them apart."""

"""pocketsphinx: the decoder, evidence for commands, keyphrases."""

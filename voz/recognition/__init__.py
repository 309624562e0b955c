"""From sound to utterances: pocketsphinx set up well, and how sure it is."""

"""From the command list to what the decoder reads: dictionary, language model and grammar."""

"""The phoneme network: weights, likelihoods, CTC, scores, sentence search."""

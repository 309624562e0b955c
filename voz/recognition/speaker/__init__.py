"""Adaptation to a speaker and a microphone."""

"""Print what is said in a recording, 16 kHz, one channel, 16 bits: pocketsphinx."""

from pocketsphinx import AudioFile

for phrase in AudioFile("take.wav"):
    print(phrase)

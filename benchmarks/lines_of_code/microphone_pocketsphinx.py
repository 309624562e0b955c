"""Print what is said into the microphone: pocketsphinx."""

from pocketsphinx import LiveSpeech

for phrase in LiveSpeech():
    print(phrase)

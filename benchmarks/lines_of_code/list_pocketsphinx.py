"""Print which of three commands is said into the microphone: pocketsphinx."""

from pocketsphinx import LiveSpeech

for phrase in LiveSpeech(lm=None, jsgf="list_pocketsphinx.gram"):
    print(phrase)

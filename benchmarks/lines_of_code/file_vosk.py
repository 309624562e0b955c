"""Print what is said in a recording, one channel, 16 bits: vosk."""

import json
import wave

from vosk import KaldiRecognizer, Model

with wave.open("take.wav") as file:
    recognizer = KaldiRecognizer(Model(lang="en-us"), file.getframerate())
    while block := file.readframes(4000):
        if recognizer.AcceptWaveform(block):
            print(json.loads(recognizer.Result())["text"])
print(json.loads(recognizer.FinalResult())["text"])

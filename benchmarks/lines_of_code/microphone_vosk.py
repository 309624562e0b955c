"""Print what is said into the microphone: vosk."""

import json

from sounddevice import RawInputStream
from vosk import KaldiRecognizer, Model

recognizer = KaldiRecognizer(Model(lang="en-us"), 16000)
with RawInputStream(samplerate=16000, dtype="int16", channels=1) as stream:
    while True:
        if recognizer.AcceptWaveform(bytes(stream.read(4000)[0])):
            print(json.loads(recognizer.Result())["text"])

"""Print which of three commands is said into the microphone: SpeechRecognition."""

from contextlib import suppress

import speech_recognition as sr

commands = [("go forward", 0.9), ("turn left", 0.9), ("stop", 0.9)]
recognizer = sr.Recognizer()
with sr.Microphone() as source:
    while True:
        with suppress(sr.UnknownValueError):
            print(recognizer.recognize_sphinx(recognizer.listen(source), keyword_entries=commands))

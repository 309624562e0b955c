"""Print what is said into the microphone: SpeechRecognition, which calls pocketsphinx."""

from contextlib import suppress

import speech_recognition as sr

recognizer = sr.Recognizer()
with sr.Microphone() as source:
    while True:
        with suppress(sr.UnknownValueError):
            print(recognizer.recognize_sphinx(recognizer.listen(source)))

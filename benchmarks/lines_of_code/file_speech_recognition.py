"""Print what is said in a recording: SpeechRecognition, which calls pocketsphinx."""

import speech_recognition as sr

recognizer = sr.Recognizer()
with sr.AudioFile("take.wav") as source:
    print(recognizer.recognize_sphinx(recognizer.record(source)))

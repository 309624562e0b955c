#!/bin/sh
# The whole way once: commands to language files, a recording to motion, replies to sound.
set -eu
cd "$(dirname "$0")/.."
voz=.venv/bin/voz
recording=audio_fixtures/long/session.wav
mkdir -p demo

step() { printf '\n== %s\n\n' "$1"; }

step "1. Make the language files from lm/comandos_voz.txt"
$voz build-lm

step "2. Drive a robot by $recording: eleven commands in 22 s, no microphone, no robot"
$voz run --wav "$recording" --events demo/events.jsonl --no-sound

step "3. Let the robot answer"
$voz say "bep bep. I am listening you" --out demo/listening.wav
$voz say "bep bep. I stop listening" --out demo/stopped.wav

step "4. Drive a robot through a room by the same recording, and draw its way"
$voz run --wav "$recording" --robot simulator --picture demo.png --no-sound

cat <<'END'
demo/events.jsonl    everything that happened, a line of JSON each
demo/listening.wav   what the robot says to "start speech"
demo/stopped.wav     what the robot says to "stop speech"
demo.png             the way that it drove

Now you: edit lm/comandos_voz.txt, then   .venv/bin/voz build-lm
         speak to it:                     .venv/bin/voz run
         type commands yourself:          .venv/bin/voz run --text -
         decode your own recordings:      .venv/bin/voz decode FILE...
END

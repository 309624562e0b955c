"""Start voz by the options of the add-on, and say to Home Assistant where it is: start.py."""

import json
import os
import socket
import subprocess
import sys
import time
from pathlib import Path
from urllib.request import Request, urlopen

DATA = Path(os.environ.get("VOZ_DATA", "/data"))
"""Where the Supervisor writes the options, and what is kept between two starts."""

PORT = int(os.environ.get("VOZ_PORT", "10300"))

SUPERVISOR = os.environ.get("VOZ_SUPERVISOR", "http://supervisor")

PATIENCE = 60.0
"""For voz to answer, s; it takes a second or two, on a small computer more."""


def arguments() -> list[str]:
    """Return the command that starts voz; builds the language files of a list."""
    options = json.loads((DATA / "options.json").read_text(encoding="utf-8"))
    alarms = str(options["false_alarms_per_hour"])
    # Not announced by zeroconf: in a container that would name an address nobody reaches.
    started = ["voz", "serve", "--wyoming", f"tcp://0.0.0.0:{PORT}", "--no-zeroconf"]
    started += ["--false-alarms-per-hour", alarms]
    if options["commands"]:
        commands, files = DATA / "commands.txt", DATA / "lm"
        commands.write_text("\n".join(options["commands"]) + "\n", encoding="utf-8")
        built = subprocess.run(["voz", "build-lm", str(commands), "--out", str(files)])
        if built.returncode:
            sys.exit(built.returncode)
        started += ["--lm", str(files)]
    return started


def announce() -> None:
    """Wait until voz answers, and send the Supervisor its address."""
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        try:
            socket.create_connection(("127.0.0.1", PORT)).close()
            break
        except OSError:
            time.sleep(0.2)
    else:
        return  # it has ended, and said why
    host = socket.gethostname()
    found = {"service": "wyoming", "config": {"uri": f"tcp://{host}:{PORT}"}}
    headers = {
        "Authorization": f"Bearer {os.environ.get('SUPERVISOR_TOKEN', '')}",
        "Content-Type": "application/json",
    }
    request = Request(f"{SUPERVISOR}/discovery", json.dumps(found).encode(), headers)
    try:
        urlopen(request, timeout=10).close()
    except OSError as error:
        print(f"add the integration Wyoming Protocol by hand: host {host}, port {PORT} ({error})")


if __name__ == "__main__":
    command = arguments()
    if os.fork() == 0:
        announce()
    else:
        os.execvp(command[0], command)

#!/bin/sh
# Installs what voz needs on Debian or Ubuntu, and only what is missing.
#
#   sh tools/install.sh          to run it: system packages, and voz in the folder .venv
#   sh tools/install.sh tests    what the tests need as well
#
# Set PYTHON to use another Python than `python3`.
set -eu
cd "$(dirname "$0")/.."

python=${PYTHON:-python3}
extra=
packages="festival festvox-kallpc16k libportaudio2"
why="festival and its voice speak the replies, PortAudio plays them"
if [ "${1:-}" = tests ]; then
    extra="[dev]"
    packages="$packages festvox-kdlpc16k festvox-us-slt-hts flite espeak-ng"
    packages="$packages pulseaudio pulseaudio-utils libasound2-plugins ffmpeg"
    why="$why; the tests use more voices, pulseaudio as a microphone and a loudspeaker without hardware, and ffmpeg"
fi

# A Python that cannot make a virtual environment, or none at all, is the system's.
if ! "$python" -c "import ensurepip, venv" 2>/dev/null; then
    packages="$packages python3 python3-venv"
    why="$why; Python runs it all"
fi

missing=
for package in $packages; do
    status=$(dpkg-query --show --showformat='${db:Status-Status}' "$package" 2>/dev/null || true)
    [ "$status" = installed ] || missing="$missing $package"
done
if [ -n "$missing" ]; then
    sudo=
    [ "$(id -u)" = 0 ] || sudo=sudo
    echo "Installing system packages with ${sudo:+$sudo }apt-get:$missing"
    echo "($why)"
    $sudo apt-get update -qq
    # shellcheck disable=SC2086 # the packages are words of their own
    $sudo env DEBIAN_FRONTEND=noninteractive \
        apt-get install -y -qq --no-install-recommends $missing >/dev/null
fi

if ! "$python" -c "import sys; sys.exit(sys.version_info < (3, 10))"; then
    echo "voz needs Python 3.10 or newer, $python is $("$python" -V); set PYTHON to another" >&2
    exit 2
fi
[ -x .venv/bin/python ] || "$python" -m venv .venv

# Nothing to do when this was done before and pyproject.toml is still the same.
stamp=".venv/installed${extra}"
if [ ! -e "$stamp" ] || [ pyproject.toml -nt "$stamp" ]; then
    echo "Installing voz$extra and the Python packages it needs into .venv"
    # Not every Python has a ready-made wheel of the newest pocketsphinx: then the one before it.
    .venv/bin/python -m pip install --quiet --disable-pip-version-check --prefer-binary \
        --editable ".$extra"
    touch "$stamp"
fi

# The real rclpy, to compare ROS 2 with: unofficial wheels, for x86-64 only, and in an environment of
# their own. Elsewhere the header of the test run says that this comparison is not made.
rclpy=9.1.2
stamp=".venv-rclpy/installed-$rclpy"
if [ "${1:-}" = tests ] && [ "$(uname -m)" = x86_64 ] && [ ! -e "$stamp" ]; then
    echo "Installing rclpy $rclpy into .venv-rclpy (250 MB; the tests compare ROS 2 with it)"
    "$python" -m venv .venv-rclpy
    .venv-rclpy/bin/python -m pip install --quiet --disable-pip-version-check --only-binary :all: \
        "ros-rclpy[fastrtps]==$rclpy" ros-std-msgs ros-geometry-msgs ros-diagnostic-msgs
    touch "$stamp"
fi

#!/bin/sh
# Installs what voz needs on Debian or Ubuntu, and only what is missing.
#
#   sh tools/install.sh          to run it: system packages, and voz in the folder .venv
#   sh tools/install.sh demo     what draws pictures as well
#   sh tools/install.sh bags     an optional part of pyproject.toml as well; so for docs, report, ros2, web, wyoming
#   sh tools/install.sh training what makes the weights of the phoneme network, in the folder .venv-training
#   sh tools/install.sh ros1     ROS 1 as well, with voz for it in the folder .venv-ros1
#   sh tools/install.sh tests    what the tests need as well, ROS 1 too
#
# Set PYTHON to use another Python than `python3`; ROS 1 has Debian's. The versions of Python packages are those
# of constraints.txt; with CONSTRAINTS=/dev/null they are the newest that pyproject.toml allows.
set -eu
cd "$(dirname "$0")/.."

python=${PYTHON:-python3}
constraints=${CONSTRAINTS:-constraints.txt}
extra=
packages="festival festvox-kallpc16k libportaudio2 espeak-ng"
why="festival and its voice speak the replies, PortAudio plays them, espeak-ng knows other languages"
ros1=
if [ "${1:-}" = ros1 ] || [ "${1:-}" = tests ]; then
    ros1="python3-rospy python3-std-msgs python3-geometry-msgs python3-nav-msgs python3-tf2-msgs"
    ros1="$ros1 python3-actionlib-msgs python3-std-srvs python3-roslaunch python3-rosmaster python3-rostopic"
    ros1="$ros1 python3-rosnode python3-rosservice python3-rosparam python3-venv"
fi
case "${1:-}" in
    demo) extra="[report]" ;;
    bags | docs | report | ros2 | web | wyoming) extra="[$1]" ;;
esac
if [ "${1:-}" = tests ]; then
    extra="[dev]"
    packages="$packages festvox-kdlpc16k festvox-us-slt-hts flite"
    packages="$packages pulseaudio pulseaudio-utils libasound2-plugins ffmpeg systemd chromium"
    packages="$packages catkin g++ make colcon python3-colcon-ros python3-ament-index mosquitto mosquitto-clients"
    why="$why; the tests use more voices, pulseaudio as a microphone and a loudspeaker without hardware, ffmpeg,"
    why="$why what builds packages of ROS 1 and 2, chromium for the operator page, and a broker of MQTT"
fi

# For the client of ROS 1 that the tests compare with. Another npm than Debian's will do.
if [ "${1:-}" = tests ] && ! command -v npm >/dev/null; then
    packages="$packages nodejs npm"
fi

sudo=
[ "$(id -u)" = 0 ] || sudo=sudo

# Install those of some packages that are missing, and say why.
install_packages() {
    missing=
    for package in $1; do
        status=$(dpkg-query --show --showformat='${db:Status-Status}' "$package" 2>/dev/null || true)
        [ "$status" = installed ] || missing="$missing $package"
    done
    [ -n "$missing" ] || return 0
    echo "Installing system packages with ${sudo:+$sudo }apt-get:$missing"
    echo "($2)"
    # shellcheck disable=SC2086 # the packages are words of their own
    $sudo apt-get update -qq && $sudo env DEBIAN_FRONTEND=noninteractive \
        apt-get install -y -qq --no-install-recommends $missing >/dev/null && return 0
    echo "They could not be installed. Who administers this computer can do it, then call make again:" >&2
    echo "    apt-get install --no-install-recommends$missing" >&2
    exit 2
}

# A Python that cannot make a virtual environment, or none at all, is the system's.
"$python" -c "import ensurepip, venv" 2>/dev/null || install_packages "python3 python3-venv" "Python runs it all"
if ! "$python" -c "import sys; sys.exit(sys.version_info < (3, 10))"; then
    echo "voz needs Python 3.10 or newer, $python is $("$python" -V); set PYTHON to another" >&2
    exit 2
fi

# Install Python packages into a virtual environment. Each module is compiled when it is first imported, as
# most never are.
pip_install() {
    environment=$1
    shift
    "$environment/bin/python" -m pip install --quiet --no-compile --disable-pip-version-check "$@"
}

# Whether a package is installed in an environment, or has a wheel for its Python.
has_wheel() {
    "$1/bin/python" -c "import $2" 2>/dev/null && return 0
    wheel=$(mktemp -d)
    found=0
    "$1/bin/python" -m pip download --quiet --disable-pip-version-check --no-deps --only-binary :all: --dest "$wheel" \
        "$2$3" >/dev/null 2>&1 || found=1
    rm -r "$wheel"
    return $found
}

# Install voz with an extra into a virtual environment. Nothing to do when this was done before and
# what it is made by is still the same.
install_voz() {
    stamp="$1/installed$2"
    if [ ! -e "$stamp" ] || [ pyproject.toml -nt "$stamp" ] || [ "$constraints" -nt "$stamp" ]; then
        echo "Installing voz$2 and the Python packages it needs into $1"
        # Once this was called `voz`, as a package of PyPI's is that others made.
        "$1/bin/python" -m pip uninstall --quiet --quiet --yes voz
        # Not every Python has a ready-made wheel of the newest pocketsphinx: then the one before it.
        pip_install "$1" --prefer-binary --constraint "$constraints" --editable ".$2"
        touch "$stamp"
    fi
}

[ -x .venv/bin/python ] || "$python" -m venv .venv
has_wheel .venv pocketsphinx ">=5.0.4" ||
    install_packages "gcc g++ libc6-dev python3-dev" "pocketsphinx has no wheel for this Python, and is compiled"
if [ "${1:-}" = ros2 ] && ! has_wheel .venv cyclonedds ">=11"; then
    echo "ROS 2 needs cyclonedds, which has no wheel for $("$python" -V) on this processor; set PYTHON to another" >&2
    exit 2
fi

# PyTorch is large and only for teaching, and has an environment of its own. PyTorch's own address has a
# build for processors alone, 200 MB; where that cannot be reached, PyPI's may bring several GB for GPUs.
torch=torch==2.13.0
install_torch() {
    [ -x .venv-training/bin/python ] || "$python" -m venv .venv-training
    if ! .venv-training/bin/python -c "import torch" 2>/dev/null; then
        echo "Installing PyTorch into .venv-training"
        pip_install .venv-training --retries 0 --timeout 10 \
            --index-url https://download.pytorch.org/whl/cpu "$torch" 2>/dev/null ||
            pip_install .venv-training "$torch"
    fi
    install_voz .venv-training "[training]"
}

# The real rclpy, to compare ROS 2 with: unofficial wheels, for x86-64 only, and in an environment of
# their own. Elsewhere the header of the test run says that this comparison is not made.
rclpy=9.1.2
install_rclpy() {
    stamp=".venv-rclpy/installed-$rclpy-with-nav"
    [ "$(uname -m)" = x86_64 ] && [ ! -e "$stamp" ] || return 0
    echo "Installing rclpy $rclpy into .venv-rclpy (250 MB; the tests compare ROS 2 with it)"
    "$python" -m venv .venv-rclpy
    pip_install .venv-rclpy --prefer-binary \
        "ros-rclpy[fastrtps]==$rclpy" ros-std-msgs ros-geometry-msgs ros-diagnostic-msgs \
        ros-nav-msgs
    touch "$stamp"
}

# Packages of Python beside those of the system: each takes a minute or more.
install_voz .venv "$extra" &
voz=$!
others=
if [ "${1:-}" = training ] || [ "${1:-}" = tests ]; then
    (
        install_torch
        [ "$1" = training ] || install_rclpy
    ) &
    others=$!
fi
# shellcheck disable=SC2086 # there may be none
trap 'kill "$voz" $others 2>/dev/null || true' EXIT

broker=/usr/sbin/mosquitto
[ ! -x $broker ] || broker=
install_packages "$packages" "$why"
# Debian starts the broker that it installs; the tests start their own.
[ ! -x "$broker" ] || $sudo systemctl disable --quiet --now mosquitto 2>/dev/null || true

wait "$voz"
[ -z "$others" ] || wait "$others"
trap - EXIT

# Install what a folder of tests has from npm, if a package of it is missing.
install_node_modules() {
    [ ! -e "$1/node_modules/$2" ] || return 0
    echo "Installing $3 for the tests into $1/node_modules"
    npm install --prefix "$1" --loglevel error --no-audit --no-fund --no-package-lock || {
        echo "npm could not install $2, which the tests need; is its registry reachable?" >&2
        exit 2
    }
}

if [ "${1:-}" = tests ]; then
    install_node_modules tests/ros1 @foxglove/ros1 "a client of ROS 1"
    install_node_modules tests/apps/web axe-core "what finds barriers in a page"
fi

if [ -n "$ros1" ]; then
    if ! install_packages "$ros1" "ROS 1, for robots that are driven by it"; then
        echo "ROS 1 cannot be installed: this system has no packages of it; Debian 12 and 13 have" >&2
        exit 2
    fi
    # rospy is there for the system's Python alone, and its own environment sees it.
    [ -x .venv-ros1/bin/python ] || /usr/bin/python3 -m venv --system-site-packages .venv-ros1
    install_voz .venv-ros1 ""
fi

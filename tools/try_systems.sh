#!/bin/sh
# Try the two commands of the README on systems as they come, each in a folder of its own:
#
#   sudo sh tools/try_systems.sh                  Debian 12, Debian 13 and Ubuntu 24.04
#   sudo sh tools/try_systems.sh trixie           Debian 13 alone
#   sudo TARGETS=demo sh tools/try_systems.sh     `make demo` alone
#   sudo TARGETS=hour sh tools/try_systems.sh     the first hour of README and lesson, timed by step
#
# It needs debootstrap, for Ubuntu its ubuntu-archive-keyring too, 6 GB of disk a system, and half an hour. The
# last commit is tried. What this computer tells pip of mirrors and certificates holds there, too.
set -eu
cd "$(dirname "$0")/.."

folder=$(mktemp -d "${TMPDIR:-/tmp}/voz-systems.XXXXXX")
mounted=
trap 'for each in $mounted; do umount -l "$each"; done; rm -rf --one-file-system "$folder"' EXIT

mirror_of() {
    case "$1" in
        bookworm | trixie) echo http://deb.debian.org/debian ;;
        *) echo http://archive.ubuntu.com/ubuntu ;;
    esac
}

# Make the system of a suite, with a clone of voz in it.
prepare() {
    system=$folder/$1
    components=main
    case "$1" in bookworm | trixie) ;; *) components=main,universe ;; esac
    debootstrap --variant=minbase --components="$components" --include=ca-certificates,git,make \
        "$1" "$system" "$(mirror_of "$1")" >"$system.log" 2>&1 || {
        tail -n 3 "$system.log" >&2
        echo "$1: debootstrap failed" >&2
        return 1
    }
    git clone --quiet . "$system/root/voz"
    for file in /etc/resolv.conf /etc/pip.conf /etc/ssl/certs/ca-certificates.crt; do
        [ ! -e "$file" ] || cp -L "$file" "$system$file"
    done
    for mount in proc dev sys; do
        mount --rbind "/$mount" "$system/$mount"
        mount --make-rslave "$system/$mount"
        mounted="$system/$mount $mounted"
    done
}

failed=
for suite in ${*:-bookworm trixie noble}; do
    echo "== $suite"
    prepare "$suite" || { failed="$failed $suite"; continue; }
    for target in ${TARGETS:-demo test}; do
        # What types the hour is a program of Python's.
        [ "$target" != hour ] || chroot "$folder/$suite" apt-get install -y -qq python3 >/dev/null 2>&1
        begun=$(date +%s)
        if chroot "$folder/$suite" /usr/bin/env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin \
            LANG=C.UTF-8 ${PIP_CERT:+PIP_CERT="$PIP_CERT"} make -C /root/voz "$target" >"$folder/$suite.$target" 2>&1; then
            echo "$suite: make $target: $(($(date +%s) - begun)) s"
            [ "$target" != hour ] || grep "^|" "$folder/$suite.$target"
        else
            tail -n 40 "$folder/$suite.$target"
            echo "$suite: make $target failed after $(($(date +%s) - begun)) s"
            failed="$failed $suite"
        fi
    done
done
[ -z "$failed" ] || { echo "failed:$failed" >&2; exit 1; }

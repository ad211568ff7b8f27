#!/bin/sh
# Prepares a machine: `prepare.sh run` for the program, `prepare.sh cad` for STEP and IGES files as
# well, `prepare.sh test` for the tests,
# `prepare.sh peers` for what Georibbon is measured against, in .venv-peers.
#
# Makes .venv, installs the locked requirements (every file checked against its hash) and Georibbon
# itself, and sees that the system's libraries are there: installed with apt-get where that may be
# done without asking for a password, told otherwise.  PYTHON names the interpreter to use.
set -eu
cd "$(dirname "$0")/.."
python=${PYTHON:-python3}
environment=.venv
[ "${1:-}" = peers ] && environment=.venv-peers
venv=$environment/bin/python

say() { printf '== %s\n' "$*"; }
stop() {
    printf 'Georibbon: %s\n' "$*" >&2
    exit 1
}

# Installs Debian packages, or says how to and stops.
packages() {
    if ! command -v apt-get >/dev/null 2>&1; then
        stop "this system lacks what Debian and Ubuntu call $*; install it and run make again."
    elif [ "$(id -u)" = 0 ]; then
        as_root=
    elif command -v sudo >/dev/null 2>&1 && sudo -n true 2>/dev/null; then
        as_root="sudo -n"
    else
        stop "this system lacks $*; run this and then make again:
    sudo apt-get update && sudo apt-get install -y $*"
    fi
    say "Installing system packages: $*"
    $as_root apt-get update -qq
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq -o Dpkg::Use-Pty=0 \
        --no-install-recommends "$@" >/dev/null
}

find_python() {
    command -v "$python" >/dev/null 2>&1 || packages python3 python3-venv
    "$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || stop \
        "$python is $("$python" --version 2>&1), and 3.11 or newer is needed;" \
        "name another one: make PYTHON=python3.12 demo"
    "$python" -c 'import ensurepip, venv' 2>/dev/null || packages \
        "$("$python" -c 'import sys; print("python%d.%d-venv" % sys.version_info[:2])')"
}

make_environment() {
    if ! "$venv" -m pip --version >/dev/null 2>&1; then
        find_python
        say "Making a virtual environment in $environment ($("$python" --version))"
        "$python" -m venv --clear "$environment"
    fi
}

install() {
    "$venv" -m pip install --quiet --no-input --disable-pip-version-check "$@"
}

requirements() {
    install --require-hashes --only-binary :all: "$@"
}

libraries() {
    missing=$("$venv" packaging/missing_libraries.py "$1")
    [ -z "$missing" ] && return
    # Words on purpose: one package each.
    # shellcheck disable=SC2086
    packages $missing
    missing=$("$venv" packaging/missing_libraries.py "$1")
    [ -z "$missing" ] || stop "what $missing should bring still cannot be loaded"
}

case ${1:-} in
run)
    make_environment
    say "Installing what Georibbon runs on (packaging/requirements.lock)"
    requirements -r packaging/requirements.lock -r packaging/requirements-build.lock
    install --no-deps --no-build-isolation --editable .
    libraries run
    ;;
cad)
    say "Installing the CAD kernel (packaging/requirements-cad.lock)"
    requirements -r packaging/requirements-cad.lock
    libraries cad
    ;;
test)
    say "Installing what the tests need (packaging/requirements-dev.lock)"
    requirements -r packaging/requirements-dev.lock
    libraries test
    ;;
peers)
    make_environment
    say "Installing Georibbon's peers (packaging/requirements-peers.lock; 250 MB to download)"
    requirements -r packaging/requirements-peers.lock
    install --no-deps --no-build-isolation --editable .
    libraries peers
    ;;
*)
    stop "say what to prepare: prepare.sh run, cad, test or peers"
    ;;
esac

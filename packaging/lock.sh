#!/bin/sh
# Writes the locked requirements anew from pyproject.toml: for every Python from 3.11 on and every
# system, with hashes.  Arguments are passed on, such as `--upgrade` or `--upgrade-package numpy`.
set -eu
cd "$(dirname "$0")/.."

compile() {
    output=$1
    shift
    .venv/bin/python -m uv pip compile --quiet --universal --python-version 3.11 --generate-hashes \
        --no-header --no-annotate --no-emit-index-url --no-emit-find-links \
        --output-file "packaging/$output" "$@"
}

compile requirements.lock pyproject.toml "$@"
compile requirements-build.lock --group build --constraint packaging/requirements.lock "$@"
compile requirements-cad.lock pyproject.toml --extra cad --constraint packaging/requirements.lock "$@"
compile requirements-dev.lock pyproject.toml --group dev --constraint packaging/requirements.lock "$@"
compile requirements-peers.lock --group build --group peers \
    --constraint packaging/requirements.lock --constraint packaging/requirements-build.lock "$@"

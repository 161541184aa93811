#!/bin/sh
# Make the virtual environment: environment.sh FOLDER run|dev|character
# Torch comes from its CPU index where that answers (the default index would bring gigabytes of CUDA), else from pip's
# own index. MOTIONLOOM_TORCH_INDEX chooses another index; empty skips straight to pip's own.
set -eu
venv=$1 kind=$2
torch=torch==2.13.0
index=${MOTIONLOOM_TORCH_INDEX-https://download.pytorch.org/whl/cpu}

python=
for candidate in python3.11 python3.12 python3; do
    if command -v "$candidate" >/dev/null 2>&1 &&
        "$candidate" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info < (3, 13))'; then
        python=$candidate
        break
    fi
done
[ -n "$python" ] || { echo "motionloom needs Python 3.11 or 3.12; none was found on PATH." >&2; exit 1; }

[ -x "$venv/bin/python" ] || "$python" -m venv "$venv"
pip() { "$venv/bin/python" -m pip --disable-pip-version-check "$@"; }
echo "Installing into $venv (a few minutes the first time) ..."
pip install --quiet --upgrade 'pip>=25.1'
if ! "$venv/bin/python" -c 'import torch' 2>/dev/null; then
    if [ -z "$index" ] || ! pip install --quiet --retries 0 --timeout 10 --index-url "$index" "$torch" 2>/dev/null; then
        pip install --quiet "$torch"
    fi
fi
pip install --quiet -e .
if [ "$kind" != run ]; then
    # only the networks in its wheel are read, so nothing it asks for is installed (it asks for an old NumPy)
    pip install --quiet --no-deps mediapipe==0.10.21
fi
case $kind in
character) pip install --quiet -e '.[character]' ;;
dev)
    pip install --quiet --group dev
    touch "$venv/.dev"
    ;;
esac
touch "$venv/.run"

#!/bin/sh
# The tests of the core that need no Python (tests/native), built and run; arguments go to ctest.
# Needs a C++ compiler, and cmake: that of .venv or an installed one, 3.18 or newer.
set -e
cd "$(dirname "$0")/.."
PATH=$PWD/.venv/bin:$PATH
cmake -S . -B build/native -DHALFPHYSICS_PYTHON=OFF -DHALFPHYSICS_BUILD_TESTS=ON >/dev/null
cmake --build build/native -j "${JOBS:-2}"
# Not --test-dir: that came with cmake 3.20.
cd build/native && ctest --output-on-failure "$@"

#!/bin/sh
# The tests of the core that need no Python (tests/native), built and run; arguments go to ctest.
# Needs a C++ compiler, and cmake 3.18 or newer: an installed one, that of .venv, or one from PyPI.
# Compiled with -O1: a quarter less work, and the tests of the C library then compare it, to the bit, with
# extensions that the compiler has optimized otherwise.
set -e
cd "$(dirname "$0")/.."
PATH=$PATH:$PWD/.venv/bin
command -v cmake >/dev/null 2>&1 || .venv/bin/python -m pip install --quiet "cmake>=3.18"
cmake -S . -B build/native -DHALFPHYSICS_PYTHON=OFF -DHALFPHYSICS_BUILD_TESTS=ON -DHALFPHYSICS_C=ON \
  -DHALFPHYSICS_OPTIMIZE=-O1 >/dev/null
cmake --build build/native -j "${JOBS:-2}"
# Not --test-dir: that came with cmake 3.20.
cd build/native && ctest --output-on-failure "$@"

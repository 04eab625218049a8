#!/bin/sh
# Development build: compiles the native core next to the Python sources, so that
# `PYTHONPATH=src python ...` and `pytest` use it at once. Needs nanobind and cmake.
set -e
cd "$(dirname "$0")/.."
python=${PYTHON:-python3}
cmake -S . -B build/inplace -DHALFPHYSICS_INPLACE=ON -DHALFPHYSICS_BUILD_TESTS=ON -DHALFPHYSICS_C=ON \
  -DHALFPHYSICS_UNITY=OFF -DPython_EXECUTABLE="$(command -v "$python")" >/dev/null
cmake --build build/inplace -j "${JOBS:-2}"

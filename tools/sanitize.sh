#!/usr/bin/env bash
# The tests of the native core under the address and undefined-behaviour sanitizers of g++.
#
#   tools/sanitize.sh                 the tests listed below
#   tools/sanitize.sh tests/base ...        others; arguments go to pytest
#
# Installs this checkout, instrumented, into build/sanitize, and runs it with the Python of .venv
# (made by ./run test), or of PYTHON, which needs the test extra. Linux; needs g++. On all cores, each
# file's tests in one process. Compiled with -O1: that takes a quarter of the time of -O3.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

die() { printf 'sanitize: %s\n' "$*" >&2; exit 1; }

site=$PWD/build/sanitize/site
python=${PYTHON:-.venv/bin/python}
cxx=${CXX:-g++}

[ "$(uname -s)" = Linux ] || die "this runs on Linux only"
"$python" -c 'import pytest, xdist, hypothesis, coal' 2>/dev/null ||
  die "$python not found or without the test extra. Make it: ./run test"
command -v "$cxx" >/dev/null 2>&1 || die "$cxx not found. Install it: apt install g++"

# g++ prints a bare name for what it does not have.
preload=
for library in libasan.so libubsan.so libstdc++.so; do
  path=$("$cxx" -print-file-name="$library")
  [ "$path" != "$library" ] ||
    die "$library of $cxx not found: the sanitizers need g++ and its libraries. Install them: apt install g++"
  # Exceptions are intercepted only where the C++ library is there from the start.
  preload=${preload:+$preload:}$path
done

if "$python" -m pip --version >/dev/null 2>&1; then
  pip=("$python" -m pip)
elif python3 -m pip --version >/dev/null 2>&1; then
  pip=(python3 -m pip --python "$python")
else
  die "pip not found. Install it: apt install python3-pip"
fi

flags="-fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer -g1"
rm -rf "$site"
CXX=$cxx "${pip[@]}" install --disable-pip-version-check --no-input --quiet --no-deps \
  --target "$site" --config-settings=build-dir=build/sanitize/cmake \
  --config-settings=cmake.build-type=RelWithDebInfo --config-settings=install.strip=false \
  --config-settings=cmake.define.HALFPHYSICS_OPTIMIZE=-O1 \
  --config-settings=cmake.define.CMAKE_CXX_FLAGS="$flags" .
for module in _native _render; do
  grep -q __asan_init "$site/halfphysics/$module".*so ||
    die "the module $module in $site is not instrumented"
done

if [ $# -eq 0 ]; then
  # Slow tests run the same code for longer; the fuzzer's cases are new.
  set -- -m "not slow or fuzz" \
    tests/native/dynamics/test_kinematic_tree.py tests/native/geometry/test_convex.py \
    tests/reference/test_step.py tests/simulation/test_{mesh_trees,simulator,objects,fuzz}.py \
    tests/body/test_skinning.py tests/geometry/test_mesh_queries.py \
    tests/metrics/test_penetration.py tests/render/test_{result_meshes,rasterizer,contact_sheet}.py \
    tests/labels/test_{contact_labels,reference}.py
fi
export PYTHONPATH=$site HALFPHYSICS_FUZZ=${HALFPHYSICS_FUZZ:-1}
export ASAN_OPTIONS=detect_leaks=0:abort_on_error=0 UBSAN_OPTIONS=print_stacktrace=1
export LD_PRELOAD=$preload
found=$("$python" -c 'import halfphysics._native as n; print(n.__file__)')
case $found in "$site"/*) ;; *) die "the tests would use $found instead of $site" ;; esac
# What the sanitizers say goes to the file of errors itself: pytest must not hold that back.
exec "$python" -m pytest -p no:cacheprovider --capture=sys -n auto --dist loadfile "$@"

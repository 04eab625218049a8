#!/bin/sh
# clang-format and clang-tidy on the native core and its tests, as ./run check runs them. Of the versions
# that pyproject.toml pins (extra `dev`), from .venv.
#
# What clang-tidy found nothing in is remembered in build/tidy, by the content of the file, of all
# headers and of .clang-tidy. The bindings are left out: most of what they include is nanobind's.
set -eu
cd "$(dirname "$0")/.."
PATH=$PWD/.venv/bin:$PATH
jobs=${JOBS:-$(getconf _NPROCESSORS_ONLN)}

failed=0
find src/native tests/native -name '*.cpp' -o -name '*.h' | LC_ALL=C sort |
  xargs clang-format --dry-run -Werror || failed=1

mkdir -p build/tidy
headers=$(find src/native tests/native -name '*.h' | LC_ALL=C sort | xargs cat .clang-tidy | cksum)
find src/native tests/native -name '*.cpp' ! -path '*/bindings/*' | LC_ALL=C sort |
  HEADERS=$headers xargs -n 1 -P "$jobs" sh -c '
    clean="build/tidy/$(echo "$HEADERS" "$1" | cat - "$1" | cksum | tr -d " ")"
    [ -e "$clean" ] && exit 0
    clang-tidy --quiet "$1" -- -std=c++17 -O1 -Isrc/native -Itests/native -DHALFPHYSICS_VERSION=__FILE__ 2>/dev/null && : >"$clean"
  ' tidy || failed=1
exit $failed

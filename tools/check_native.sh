#!/bin/sh
# clang-format and clang-tidy on the native core and its tests, as ./run check runs them. Of the versions
# that pyproject.toml pins (extra `dev`), from .venv.
#
#   tools/check_native.sh --analyze   clang's static analyzer too, which takes four times as long
#
# What clang-tidy found nothing in is remembered in build/tidy, by the content of the file, of all
# headers and of .clang-tidy. The bindings are left out: most of what they include is nanobind's.
set -eu
cd "$(dirname "$0")/.."
PATH=$PWD/.venv/bin:$PATH
jobs=${JOBS:-$(getconf _NPROCESSORS_ONLN)}
checks=
# Left out of it. EnumCastOutOfRange: numbers of joint types come from MuJoCo as they are. UndefReturn: an
# obstacle is a static or an object, which the analyzer does not know.
[ "${1:-}" != --analyze ] || checks="clang-analyzer-*,-clang-analyzer-security.FloatLoopCounter\
,-clang-analyzer-optin.core.EnumCastOutOfRange,-clang-analyzer-core.uninitialized.UndefReturn"

failed=0
find src/native tests/native -name '*.cpp' -o -name '*.h' | LC_ALL=C sort |
  xargs clang-format --dry-run -Werror || failed=1

mkdir -p build/tidy
headers=$(find src/native tests/native -name '*.h' | LC_ALL=C sort | xargs cat .clang-tidy | cksum)$checks
find src/native tests/native -name '*.cpp' ! -path '*/bindings/*' | LC_ALL=C sort |
  HEADERS=$headers CHECKS=$checks xargs -n 1 -P "$jobs" sh -c '
    clean="build/tidy/$(echo "$HEADERS" "$1" | cat - "$1" | cksum | tr -d " ")"
    [ -e "$clean" ] && exit 0
    clang-tidy --quiet --checks="$CHECKS" "$1" -- -std=c++17 -O1 -Isrc/native -Itests/native -DHALFPHYSICS_VERSION=__FILE__ 2>/dev/null && : >"$clean"
  ' tidy || failed=1
exit $failed

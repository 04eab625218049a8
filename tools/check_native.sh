#!/bin/sh
# clang-format and clang-tidy on the native core and its tests, as ./run check runs them. Of the versions
# that pyproject.toml pins (extra `dev`), from .venv.
#
#   tools/check_native.sh --analyze   clang's static analyzer too, which takes 15 times as long
#
# clang-tidy reads the sources of a folder together, as they are compiled (CMakeLists.txt, HALFPHYSICS_UNITY):
# a quarter of the work, since most of that goes to what they include. Functions are not compiled for several
# processors there (HP_VECTORS): such a function must not be called before it is made. What it found nothing in
# is remembered in build/tidy, by the content of the sources, of all headers and of .clang-tidy. The bindings
# are left out: most of what they include is nanobind's.
set -eu
cd "$(dirname "$0")/.."
PATH=$PWD/.venv/bin:$PATH
jobs=${JOBS:-$(getconf _NPROCESSORS_ONLN)}
checks= by_folder='s|/[^/]*$||'
# Left out of it. EnumCastOutOfRange: numbers of joint types come from MuJoCo as they are. UndefReturn: an
# obstacle is a static or an object, which the analyzer does not know.
[ "${1:-}" != --analyze ] || checks="clang-analyzer-*,-clang-analyzer-security.FloatLoopCounter\
,-clang-analyzer-optin.core.EnumCastOutOfRange,-clang-analyzer-core.uninitialized.UndefReturn"
# It looks at nothing that is included.
[ "${1:-}" != --analyze ] || by_folder=

failed=0
find src/native tests/native -name '*.cpp' -o -name '*.h' | LC_ALL=C sort |
  xargs clang-format --dry-run -Werror || failed=1

mkdir -p build/tidy
headers=$(find src/native tests/native -name '*.h' | LC_ALL=C sort | xargs cat .clang-tidy | cksum)$checks
# Folders of the core, and tests, of which each is a program.
{
  find src/native -name '*.cpp' ! -path '*/bindings/*' | sed "$by_folder"
  find tests/native -name '*.cpp'
} | LC_ALL=C sort -u |
  HEADERS=$headers CHECKS=$checks,-bugprone-suspicious-include xargs -n 1 -P "$jobs" sh -c '
    sources=$1 read=$1
    [ ! -d "$1" ] || sources=$(ls "$1"/*.cpp) read=build/tidy/$(echo "$1" | tr / _).cpp
    clean="build/tidy/$(echo "$HEADERS" $sources | cat - $sources | cksum | tr -d " ")"
    [ -e "$clean" ] && exit 0
    [ ! -d "$1" ] || for source in $sources; do echo "#include \"$source\""; done >"$read"
    clang-tidy --quiet --checks="$CHECKS" "$read" -- -std=c++17 -O1 -I. -Isrc/native -Itests/native -DHP_VECTORS=1 -DHALFPHYSICS_VERSION=__FILE__ 2>/dev/null && : >"$clean"
  ' tidy || failed=1
exit $failed

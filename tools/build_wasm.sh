#!/bin/sh
# The core for browsers and node: compiles src/native by Emscripten to src/halfphysics/assets/core/halfphysics.wasm, and writes the
# hash of its sources beside it (tools/wasm_sources.py; a test compares). Needs em++ (Debian, Ubuntu: apt install emscripten)
# and python3. JOBS: how many files at once. Objects of unchanged sources are used again.
set -eu
cd "$(dirname "$0")/.."
build=build/wasm
target=src/halfphysics/assets/core/halfphysics.wasm
mkdir -p "$build"
version=$(sed -n 's/^project(halfphysics VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
# No contraction into fused multiply-adds, as in CMakeLists.txt: the same bits from every compiler and machine.
flags="-std=c++17 -O3 -DNDEBUG -ffp-contract=off -msimd128 -fwasm-exceptions -Wall -Wextra -Isrc/native \
-DHALFPHYSICS_STATIC -DHALFPHYSICS_VERSION=\"$version\""
python3 tools/wasm_sources.py --list | FLAGS=$flags BUILD=$build xargs -n 1 -P "${JOBS:-2}" sh -c '
  object=$BUILD/$(echo "$1" | tr / _).o
  key=$(python3 tools/wasm_sources.py --key "$1" "$FLAGS")
  [ "$(cat "$object.key" 2>/dev/null)" = "$key" ] && exit 0
  em++ $FLAGS -c "$1" -o "$object" && echo "$key" >"$object.key"
' compile
functions=$(grep -o 'hp_[a-z_]*(' src/native/capi/halfphysics.h | tr -d '(' | grep -v hp_world_open | sort -u | sed 's/^/_/' | paste -sd, -)
objects=$(python3 tools/wasm_sources.py --list | tr / _ | sed "s|^|$build/|; s|\$|.o|")
em++ -O3 -msimd128 -fwasm-exceptions -sSTANDALONE_WASM --no-entry -sALLOW_MEMORY_GROWTH -sINITIAL_MEMORY=33554432 \
  -sTOTAL_STACK=1048576 -sMAXIMUM_MEMORY=2147483648 \
  -sEXPORTED_FUNCTIONS="$functions,_malloc,_free" $objects -o "$build/halfphysics.wasm"
mv "$build/halfphysics.wasm" "$target"
python3 tools/wasm_sources.py --hash >"$target.sources"
ls -l "$target"
gzip -9 -c "$target" | wc -c

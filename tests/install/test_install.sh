#!/usr/bin/env bash
# Installs the tree that is built into a folder of its own, and builds and runs
# the project of tests/install against it, by find_package and by pkg-config.
#   test_install.sh BUILD-FOLDER SCENE.glb C-COMPILER [FLAGS]
set -euo pipefail
build=$1 scene=$2 compiler=$3 flags=${4:-}
source=$(cd "$(dirname "$0")" && pwd)
folder=$(mktemp -d)
trap 'status=$?; rm -rf "$folder"; [ $status -eq 0 ] || echo "test_install: FAILED while $step" >&2' EXIT

step="installing"
cmake --install "$build" --prefix "$folder/first" >/dev/null
mv "$folder/first" "$folder/prefix" # nothing may know where it was put
prefix=$folder/prefix

step="running the installed program"
"$prefix/bin/reframe" --version | grep -q '^reframe [0-9]'

step="looking for every option of --help in the manual page"
manual=$(sed 's/\\-/-/g' "$(find "$prefix" -name reframe.1)")
count=0
for command in $("$prefix/bin/reframe" --help | sed -n 's/^  \([a-z]\{1,\}\)  .*/\1/p'); do
    grep -q "^.SH \"reframe $command\"$" <<<"$manual"
    for option in $("$prefix/bin/reframe" "$command" --help | grep -o '^  [^ ].\{0,34\}' | grep -o -- '--[][a-z-]*' | grep -v '^--help$'); do
        grep -qF -- "$option" <<<"$manual" || { echo "the manual page lacks $command $option" >&2; exit 1; }
        count=$((count + 1))
    done
done
[ "$count" -gt 20 ]

step="converting by the installed importer"
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' >"$folder/a.obj"
"$prefix/bin/reframe" convert "$folder/a.obj" "$folder/a.glb" | grep -q '1 triangles'

step="compiling every header by itself"
export PKG_CONFIG_PATH=$(dirname "$(find "$prefix" -name reframe.pc)")
for header in $(cd "$prefix/include/reframe" && find . -name '*.h'); do
    # shellcheck disable=SC2046
    echo "#include \"$header\"" | "$compiler" -std=c11 -fsyntax-only $(pkg-config --cflags reframe) -xc -
done

step="building with find_package"
CFLAGS=$flags cmake -S "$source" -B "$folder/cmake" -DCMAKE_C_COMPILER="$compiler" -DCMAKE_PREFIX_PATH="$prefix" >"$folder/log" 2>&1 &&
    cmake --build "$folder/cmake" >>"$folder/log" 2>&1 || { cat "$folder/log" >&2; exit 1; }
step="running what find_package built"
"$folder/cmake/consumer" "$scene" "$folder/a.exr"
"$prefix/bin/reframe" png "$folder/a.exr" "$folder/a.png"

step="building with pkg-config"
# shellcheck disable=SC2046,SC2086
"$compiler" $flags -std=c11 -Wall -Wextra -Wpedantic -Werror "$source/consumer.c" -o "$folder/consumer" \
    $(pkg-config --cflags --libs reframe) -Wl,-rpath,"$(dirname "$PKG_CONFIG_PATH")"
step="running what pkg-config built"
"$folder/consumer" "$scene" "$folder/b.exr"
cmp "$folder/a.exr" "$folder/b.exr"
[ "$(pkg-config --modversion reframe)" = "$("$prefix/bin/reframe" --version | cut -d' ' -f2)" ]
echo "test_install: passed, $count options"

#!/usr/bin/env bash
# Installs the tree that is built into a folder of its own, and builds and runs
# the project of tests/install against it, in C and C++, by find_package and by
# pkg-config, with the static library and with a shared one.
#   test_install.sh BUILD-FOLDER SCENE.glb C-COMPILER C++-COMPILER [FLAGS]
set -euo pipefail
build=$1 scene=$2 compiler=$3 cpp=$4 flags=${5:-}
source=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$source/../.." && pwd)
folder=$(mktemp -d)
trap 'status=$?; rm -rf "$folder"; [ $status -eq 0 ] || echo "test_install: FAILED while $step" >&2' EXIT
warnings="-Wall -Wextra -Wpedantic -Werror"

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

step="looking for what bash and zsh complete"
for file in bash-completion/completions/reframe zsh/site-functions/_reframe; do
    grep -q -- '--weights' "$prefix/share/$file"
done

step="converting by the installed importer"
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' >"$folder/a.obj"
"$prefix/bin/reframe" convert "$folder/a.obj" "$folder/a.glb" | grep -q '1 triangles'

step="looking for headers that are not public"
[ "$(cd "$prefix/include" && find . -type f | sort)" = "$(cd "$root/src" && find ./reframe -name '*.h' | sort)" ]

# The files that the installed program writes for what consumer.c renders.
step="rendering by the program"
for seed in 1 2; do
    name=$([ $seed = 1 ] && echo one || echo two)
    "$prefix/bin/reframe" render "$scene" -o "$folder/program/$name.####.exr" --frames 4-6 --size 48x27 --spp 6 --group 1 \
        --tile 2x2 --aov albedo,depth,motion --seed $seed --quiet >/dev/null
done

# compare_files FOLDER: the consumer wrote what the program writes.
compare_files()
{
    [ "$(ls "$1")" = "$(ls "$folder/program")" ]
    for file in "$folder/program/"*; do
        cmp "$file" "$1/$(basename "$file")"
    done
}

# use_library PREFIX NAME: builds and runs the consumers against what is installed there.
use_library()
{
    local prefix=$1 name=$2 header language
    PKG_CONFIG_PATH=$(dirname "$(find "$prefix" -name reframe.pc)")
    export PKG_CONFIG_PATH
    local libraries
    libraries=$(dirname "$PKG_CONFIG_PATH")

    step="compiling every header by itself ($name)"
    for header in "$prefix/include/reframe/"*.h; do
        for language in "$compiler -xc -std=c99" "$compiler -xc -std=c11" "$cpp -xc++ -std=c++11" "$cpp -xc++ -std=c++17"; do
            # shellcheck disable=SC2046,SC2086
            echo "#include <reframe/$(basename "$header")>" | $language $warnings -fsyntax-only $(pkg-config --cflags reframe) -
        done
    done

    for language in C CXX; do
        step="building with find_package ($name, $language)"
        built=$folder/cmake-$name-$language
        CFLAGS=$flags CXXFLAGS=$flags cmake -S "$source" -B "$built" -DLANGUAGE=$language -DCMAKE_C_COMPILER="$compiler" \
            -DCMAKE_CXX_COMPILER="$cpp" -DCMAKE_PREFIX_PATH="$prefix" >"$folder/log" 2>&1 &&
            cmake --build "$built" >>"$folder/log" 2>&1 || { cat "$folder/log" >&2; exit 1; }
        step="running what find_package built ($name, $language)"
        "$built/consumer" "$scene" "$folder/$name-$language" >"$folder/told"
        compare_files "$folder/$name-$language"
        grep -q 'relMSE ' "$folder/told"
        grep -Eq '^(RF_ERROR_MEMORY|as expected): ' "$folder/told"
        grep -q 'plan: group' "$folder/told"
    done
    if "$folder/cmake-$name-C/consumer" "$folder/a.obj" "$folder/none" 2>"$folder/told"; then exit 1; fi
    grep -q 'a.obj' "$folder/told"

    step="building with pkg-config ($name)"
    # shellcheck disable=SC2046,SC2086
    "$compiler" $flags -std=c11 $warnings "$source/consumer.c" -o "$folder/consumer" \
        $(pkg-config --cflags --libs reframe) -Wl,-rpath,"$libraries"
    # shellcheck disable=SC2046,SC2086
    "$cpp" $flags -std=c++17 $warnings "$source/consumer.cpp" -o "$folder/consumer_cpp" \
        $(pkg-config --cflags --libs reframe) -Wl,-rpath,"$libraries"
    step="running what pkg-config built ($name)"
    "$folder/consumer" "$scene" "$folder/$name-pc" >/dev/null
    compare_files "$folder/$name-pc"
    "$folder/consumer_cpp" "$scene" "$folder/$name-pc" >/dev/null
    compare_files "$folder/$name-pc"
    [ "$(pkg-config --modversion reframe)" = "$("$folder/prefix/bin/reframe" --version | cut -d' ' -f2)" ]
}

other=shared
if [ "$(find "$prefix" -name 'libreframe.so')" ]; then other=static; fi
use_library "$prefix" "$([ $other = shared ] && echo static || echo shared)"

# By the target that scripts/demo builds, after which all must be there to be installed.
step="building the $other library"
target=$(sed -n 's/^cmake --build .* --target \([a-z_]*\).*/\1/p' "$root/scripts/demo")
cached() { sed -n "s/^$1:[A-Z]*=//p" "$build/CMakeCache.txt"; }
{
    cmake -G "$(cached CMAKE_GENERATOR)" -S "$root" -B "$folder/build" -DBUILD_SHARED_LIBS="$([ $other = shared ] && echo ON || echo OFF)" \
        -DREFRAME_TESTS=OFF -DCMAKE_C_COMPILER="$compiler" -DREFRAME_MARCH="$(cached REFRAME_MARCH)" \
        -DREFRAME_SANITIZE="$(cached REFRAME_SANITIZE)" -DCMAKE_C_COMPILER_LAUNCHER="$(cached CMAKE_C_COMPILER_LAUNCHER)" &&
        cmake --build "$folder/build" --target "$target" --parallel "$(nproc)" &&
        cmake --install "$folder/build" --prefix "$folder/$other"
} >"$folder/log" 2>&1 || { tail -30 "$folder/log" >&2; exit 1; }
[ -s "$(find "$folder/$other" -name reframe.1)" ]
use_library "$folder/$other" "$other"

step="looking at what the shared library shows"
library=$(find "$folder/shared" "$prefix" -name 'libreframe.so' 2>/dev/null | head -1)
python3 -B "$source/declared.py" "$root/src/reframe" >"$folder/declared"
# names that begin with a dot are clang's own, for OpenMP's critical sections
nm -D --defined-only "$library" | cut -d' ' -f3 | grep -v '^\.' | sort >"$folder/shown"
diff "$folder/declared" "$folder/shown"
[ "$(wc -l <"$folder/shown")" -gt 40 ]
echo "test_install: passed, $count options, $(wc -l <"$folder/shown") public functions"

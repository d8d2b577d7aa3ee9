#!/usr/bin/env bash
# Makes a Debian package of a static binary (tools/static_binary.sh) into FOLDER, with pages of the manual and what bash, zsh and fish
# complete. It depends on nothing; ffmpeg, for video, is recommended.
#
#     tools/debian_package.sh FINGERPOST FOLDER
#
# Needs dpkg-deb.
set -euo pipefail
program=$(realpath "$1")
mkdir -p "$2"
out=$(realpath "$2")
cd "$(dirname "$0")/.."
version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -n 1)
architecture=$(dpkg --print-architecture)
root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT
chmod 755 "$root"

install -D -m 755 "$program" "$root/usr/bin/fingerpost"
share="$root/usr/share"
mkdir -p "$share/man" "$share/bash-completion/completions" "$share/zsh/vendor-completions" "$share/fish/vendor_completions.d"
"$program" man --out "$share/man/man1"
gzip -9 --no-name "$share"/man/man1/*.1
"$program" completions bash >"$share/bash-completion/completions/fingerpost"
"$program" completions zsh >"$share/zsh/vendor-completions/_fingerpost"
"$program" completions fish >"$share/fish/vendor_completions.d/fingerpost.fish"
documents="$root/usr/share/doc/fingerpost"
install -D -m 644 -t "$documents" README.md CHANGELOG.md LICENSE-MIT LICENSE-APACHE crates/fingerpost-sim/assets/ATTRIBUTION.md
{
    printf 'Fingerpost is licensed under MIT OR Apache-2.0; the texts are LICENSE-MIT and LICENSE-APACHE beside this file.\n\n'
    cat THIRD_PARTY_NOTICES.txt
} >"$documents/copyright"
gzip -9 --no-name "$documents/CHANGELOG.md"
chmod -R u=rwX,go=rX "$root/usr"
mkdir "$root/DEBIAN"
cat >"$root/DEBIAN/control" <<CONTROL
Package: fingerpost
Version: $version
Architecture: $architecture
Maintainer: Fingerpost contributors <fingerpost@localhost>
Installed-Size: $(du -sk "$root/usr" | cut -f 1)
Recommends: ffmpeg
Section: science
Priority: optional
Description: single-camera navigation localisation
 Given one camera, an OpenStreetMap road map and a route, it finds each junction of the route in the picture, says how far ahead it
 is and how sure it is, follows it until the vehicle is there, and gives a driving line through it.
CONTROL
package="$out/fingerpost_${version}_$architecture.deb"
dpkg-deb --root-owner-group --build "$root" "$package" >/dev/null
echo "$package"

#!/bin/sh
# GMT's grdtrack has ground at -6 m beside a wall from 0 to 100 m.
#
# gmt 6.4.0+dfsg-2 of Debian 12, grdtrack along a line over posts of 0 and 100 m. Guess: heights stay between those of
# the posts. Seen: -6.25 m half a post before the wall and 106.25 m behind its edge, as the default is bicubic; 0 and
# 100 m with -nl. A flight planned 5 m above that profile is 1 m below the foot. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
system='^(libc6|libc-bin|libcrypt1|libgcc-s1|gcc-12-base|libstdc[+][+]6|debconf|cdebconf|dpkg|perl|tar)'
options='--no-recommends --no-suggests --no-conflicts --no-breaks --no-replaces --no-enhances'
# shellcheck disable=SC2086
apt-get download -qq $(apt-cache depends --recurse $options gmt | grep '^[a-z]' | grep -vE "$system" | sort -u |
  sed 's/^gmt$/gmt=6.4.0+dfsg-2/') >/dev/null 2>&1
for package in *.deb; do dpkg -x "$package" root; done
libraries=$(find "$PWD/root/usr/lib" "$PWD/root/lib" -name '*.so*' -printf '%h\n' 2>/dev/null | sort -u | tr '\n' ':')
export LD_LIBRARY_PATH="$libraries" GMT_SHAREDIR="$PWD/root/usr/share/gmt"
gmt=root/usr/bin/gmt
for row in 0 1 2 3 4 5 6 7; do
  for column in 0 1 2 3 4 5 6 7; do
    echo "8.00$column 47.00$row $((column < 4 ? 0 : 100))"
  done
done | $gmt xyz2grd -R8/8.007/47/47.007 -I0.001 -Gwall.nc
profile() {
  printf '8.0025 47.0035\n8.0035 47.0035\n8.0045 47.0035\n' | $gmt grdtrack -Gwall.nc "$@" | awk '{printf "%.2f ", $3}'
}
seen=$(profile)
linear=$(profile -nl)
echo "$($gmt --version): heights across a wall from 0 to 100 m: $seen; with -nl: $linear"
[ "$seen" = "-6.25 50.00 106.25 " ] && [ "$linear" = "0.00 50.00 100.00 " ]

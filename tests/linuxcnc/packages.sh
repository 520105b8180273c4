# Debian's packages without installing them: read by fetch.sh and fetch_headless.sh, which set
# $work (a folder with debs/ and tree/) and fail().

download() {    # package ...: into $work/debs, refreshing apt's lists only if they do not know a package
    cd "$work/debs"
    apt-get -qq download "$@" >"$work/log" 2>&1 \
        || { apt-get -qq update >"$work/log" 2>&1 && apt-get -qq download "$@" >"$work/log" 2>&1; } \
        || fail "apt-get cannot download $*: $(grep -m1 '^E:' "$work/log" || tail -n 1 "$work/log")"
    cd - >/dev/null
}

unpack() {      # pattern ...: from every downloaded package, the members whose path holds one of the patterns
    for deb in "$work"/debs/*.deb; do
        dpkg-deb --fsys-tarfile "$deb" >"$work/files.tar" || fail "$(basename "$deb") is damaged"
        tar -tf "$work/files.tar" >"$work/names"
        : >"$work/take"
        for pattern in "$@"; do grep -F -- "$pattern" "$work/names" >>"$work/take" || true; done
        grep -v '/$' "$work/take" | sort -u | tar -xf "$work/files.tar" -C "$work/tree" -T - \
            || fail "cannot unpack $(basename "$deb")"
        rm "$deb"
    done
}

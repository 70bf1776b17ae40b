#!/usr/bin/env bash
# Fuzzes what reads files, with clang's libFuzzer under address and undefined-behaviour sanitizers:
#   tests/fuzz/run.sh [SECONDS of each target] [TARGET...]
# Targets: gltf (scenes), picture (images of scenes), json (settings, scripts, cameras, paths, metadata). Findings lie in
# build-fuzz/findings, what has been learnt in build-fuzz/corpus.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
build=$root/build-fuzz
seconds=${1:-100}
[ $# -eq 0 ] || shift
targets=("$@")
[ ${#targets[@]} -gt 0 ] || targets=(gltf picture json)
if ! command -v clang++ >/dev/null; then
    echo "fuzzing left out: there is no clang++ here" >&2
    exit 0
fi
[ -f "$build/build.ninja" ] || cmake -S "$root" -B "$build" -G Ninja -DCMAKE_CXX_COMPILER=clang++ -DREKINDLE_TESTS=OFF \
    -DREKINDLE_NATIVE=OFF -DCMAKE_BUILD_TYPE=RelWithDebInfo -DCMAKE_CXX_FLAGS_RELWITHDEBINFO="-O1 -g1" \
    -DREKINDLE_SANITIZE=fuzzer-no-link,address,undefined >&2
ninja -C "$build" "${targets[@]/%/_fuzz}" >&2

# Small files of every kind to begin with.
seed() {
    mkdir -p "$build/corpus/$1"
    case $1 in
    gltf) cp "$root"/assets/{lights,glass,sky}.gltf "$root"/tests/fuzz/seeds/*.gltf "$build/corpus/$1/" ;;
    picture) cp "$root"/assets/textures/* "$build/corpus/$1/" ;;
    json)
        printf '0%s' '{"version": 1, "view": {"exposure": 2}, "presets": [], "cameras": {}, "recent": ["/a.glb"]}' \
            >"$build/corpus/$1/settings"
        printf '1%s' '{"steps": [{"repeat": 2, "steps": [{"key": "F1"}]}, {"wait": "samples", "value": 4}]}' \
            >"$build/corpus/$1/script"
        printf '2%s' '{"position": [0, 1, 5], "target": [0, 1, 0], "yfov": 40}' >"$build/corpus/$1/camera"
        printf '3%s' '{"keys": [{"frame": 0, "position": [0, 0, 5]}, {"frame": 9, "yfov": 30}]}' >"$build/corpus/$1/path"
        printf '4%s' '{"scene": "a.glb", "scene_hash": "0", "camera": "{}", "width": "8", "height": "8", "method": "path",
            "params": "{}", "spp": "1"}' >"$build/corpus/$1/metadata"
        ;;
    esac
}

export ASAN_OPTIONS=detect_leaks=1:allocator_may_return_null=1 UBSAN_OPTIONS=print_stacktrace=1
export LSAN_OPTIONS=suppressions=$root/tests/sanitizers/leaks.supp:print_suppressions=0
[ ! -w /dev/shm ] || export TMPDIR=/dev/shm  # json writes a file per input
status=0
for target in "${targets[@]}"; do
    seed "$target"
    mkdir -p "$build/findings"
    dictionary=()
    [ ! -f "$root/tests/fuzz/$target.dict" ] || dictionary=("-dict=$root/tests/fuzz/$target.dict")
    log=$build/$target.log
    if "$build/${target}_fuzz" -max_total_time="$seconds" -max_len=65536 -rss_limit_mb=2048 -timeout=20 "${dictionary[@]}" \
        -artifact_prefix="$build/findings/$target-" -print_final_stats=1 "$build/corpus/$target" >"$log" 2>&1; then
        echo "fuzz $target: $(sed -n 's/^stat::number_of_executed_units: *//p' "$log") inputs in $seconds s, nothing found"
    else
        tail -n 60 "$log"
        echo "fuzz $target: FOUND SOMETHING, see $log"
        status=1
    fi
done
exit $status

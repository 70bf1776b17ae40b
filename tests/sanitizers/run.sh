#!/usr/bin/env bash
# The tests under a sanitizer: ./test --asan (addresses, leaks, undefined behaviour) and ./test --tsan (data races).
#   tests/sanitizers/run.sh asan|tsan [gtest arguments]
# Three parts: a planted fault that must be reported, the tests, and a scripted session of the whole program in a window
# on a display without a screen. What is left out stands with its reason in MODE.skip, what foreign libraries do wrong
# in MODE.supp and leaks.supp.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
here=$root/tests/sanitizers
mode=$1
shift
build=$root/build-$mode
[ -f "$build/build.ninja" ] || (cd "$root" && cmake --preset "$mode" >&2)
ninja -C "$build" tests rekindle >&2

export ASAN_OPTIONS=detect_leaks=1:detect_stack_use_after_return=1:malloc_context_size=20:alloc_dealloc_mismatch=1
export LSAN_OPTIONS=suppressions=$here/leaks.supp:print_suppressions=0
export UBSAN_OPTIONS=print_stacktrace=1
export TSAN_OPTIONS=suppressions=$here/tsan.supp:history_size=4:second_deadlock_stack=1:print_suppressions=0
# std::regex, which only tests use, calls itself for every character of a page; frames are several times larger here.
ulimit -S -s 65536
# ThreadSanitizer of GCC 12 does not start where the kernel shuffles addresses by more than 28 bits.
fixed=()
if [ "$mode" = tsan ]; then fixed=(setarch "$(uname -m)" -R); fi

# Lines of a file without comments, joined by colons.
filters() { sed -E 's/#.*//; s/[[:space:]]+$//; /^$/d' "$1" | paste -sd:; }

# A sanitizer that was not compiled in, or is silenced, would pass everything.
canary() {
    local text
    if text=$("${fixed[@]}" "$build/tests" --gtest_also_run_disabled_tests "--gtest_filter=DISABLED_Canary.$1" 2>&1); then
        echo "canary $1: NOT REPORTED" >&2
        exit 1
    fi
    grep -q "$2" <<<"$text" || { echo "canary $1: failed, but without '$2':"; echo "$text"; exit 1; } >&2
    echo "canary $1: reported"
}
if [ "$mode" = asan ]; then
    canary WritesPastItsArray 'AddressSanitizer: heap-buffer-overflow'
    canary LosesMemory 'LeakSanitizer: detected memory leaks'
    canary OverflowsASignedNumber 'signed integer overflow'
else
    canary RacesForANumber 'ThreadSanitizer: data race'
    # On one processor TBB has one thread.
    if [ "$(nproc)" -gt 1 ]; then canary RacesInALoop 'ThreadSanitizer: data race'; fi
fi

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/reports"
# Reports of the tests and of the programs that they start go to files: none is lost among the output of a test that
# passes nevertheless.
for options in ASAN_OPTIONS UBSAN_OPTIONS TSAN_OPTIONS; do
    export "$options=${!options}:log_path=$folder/reports/report"
done

status=0
"$root/tests/shards.sh" 7200 "${fixed[@]}" "$build/tests" --gtest_color=no \
    "--gtest_filter=-$(filters "$here/$mode.skip")" "$@" || status=1

cd "$folder"
ln -s "$root/assets" assets
if XDG_CONFIG_HOME=$folder XDG_CACHE_HOME=$folder xvfb-run -a "${fixed[@]}" timeout 1200 "$build/rekindle" view \
    assets/cornell-diffuse.gltf --no-settings --size 480x300 --script "$here/session.json" >session.log 2>&1; then
    echo "session: no report"
else
    cat session.log
    echo "session: failed"
    status=1
fi
for report in "$folder"/reports/*; do
    [ -f "$report" ] || continue
    cat "$report"
    status=1
done
exit $status

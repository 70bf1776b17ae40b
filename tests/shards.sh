#!/usr/bin/env bash
# Runs tests in several processes, prints what failed or was skipped, and last how many passed:
#   tests/shards.sh SECONDS COMMAND...
# SECONDS is the limit of a process. Most tests use one processor or wait for something: one process more than there are
# processors runs at a time. Each has a small share, so that none is left with a long rest, and tests that follow each
# other, for they need the same kernels, which every process translates anew.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
limit=$1
shift
at_once=$(($(nproc) + 1))
list=$("$@" --gtest_list_tests)
mapfile -t names < <(awk '/^[^ ]/ { suite = $1; next } /./ { print suite $1 }' <<<"$list")
count=${#names[@]}
shards=$((6 * at_once < count ? 6 * at_once : count))
logs=$(mktemp -d)
trap 'rm -rf "$logs"' EXIT
status=0 running=0
for ((i = shards - 1; i >= 0; i--)); do # those with parameters stand last and take longest
    if [ $running -eq $at_once ]; then
        wait -n || status=1
        running=$((running - 1))
    fi
    first=$((i * count / shards)) end=$(((i + 1) * count / shards))
    mine=$(IFS=:; echo "${names[*]:first:end-first}")
    timeout "$limit" "$@" "--gtest_filter=$mine" >"$logs/$i" 2>&1 &
    running=$((running + 1))
done
for ((i = 0; i < running; i++)); do wait -n || status=1; done

passed=0 failed=0 skipped=0
for ((i = 0; i < shards; i++)); do
    "$root/tests/failures.sh" "$logs/$i"
    read -r p f s < <(sed -nE 's/^([0-9]+) passed, ([0-9]+) failed, ([0-9]+) skipped.*/\1 \2 \3/p' "$logs/$i" | tail -n 1
        echo 0 1 0)
    passed=$((passed + p)) failed=$((failed + f)) skipped=$((skipped + s))
done
[ "$failed" -eq 0 ] || status=1
echo "$passed passed, $failed failed, $skipped skipped"
exit $status

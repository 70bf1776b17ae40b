#!/usr/bin/env bash
# Runs the tests in several processes, prints what failed or was skipped, and last how many passed:
#   tests/shards.sh SECONDS COMMAND...
# SECONDS is the limit of a process. Most tests use one processor or wait for something: one process more than there are
# processors runs at a time, each with a sixth of its share of the tests, so that none is left with a long rest.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
limit=$1
shift
at_once=$(($(nproc) + 1))
shards=$((6 * at_once))
logs=$(mktemp -d)
trap 'rm -rf "$logs"' EXIT
status=0 running=0
for ((i = 0; i < shards; i++)); do
    if [ $running -eq $at_once ]; then
        wait -n || status=1
        running=$((running - 1))
    fi
    GTEST_TOTAL_SHARDS=$shards GTEST_SHARD_INDEX=$i timeout "$limit" "$@" >"$logs/$i" 2>&1 &
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

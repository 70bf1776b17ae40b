#!/usr/bin/env bash
# What a person wants to see of GoogleTest's output in FILE: the tests that failed with all they said, the one that never
# ended, and the names of those that were skipped with their reason.
set -euo pipefail
awk '
    function name() { return $(NF > 3 && $NF == "ms)" ? NF - 2 : NF) }
    /^\[ RUN      \]/ { inside = 1; block = $0; last = ""; next }
    /\[       OK \]/ { inside = 0; next }
    inside && /\[  SKIPPED \]/ { inside = 0; print "skipped: " name() ": " last; next }
    inside && /\[  FAILED  \]/ { inside = 0; print block; print; next }
    inside { block = block "\n" $0; if ($0 != "") last = $0; next }
    /ERROR: |WARNING: / { print }
    END { if (inside) print block "\nthe tests ended here" }
' "$1"

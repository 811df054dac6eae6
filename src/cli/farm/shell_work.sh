#!/bin/sh
# Machine @MACHINE@ renders chunks that no other has claimed. Stopped anywhere, it goes on when it is run again.
set -u
cd @FOLDER@ || exit 4
mkdir -p claims || exit 4
number=0 failed=0
while read -r frames; do
    number=$((number + 1))
    claim=claims/$number
    # Of two machines one alone can make a folder.
    if mkdir "$claim" 2>/dev/null; then
        : >"$claim/machine-@MACHINE@"
    elif [ ! -e "$claim/machine-@MACHINE@" ]; then
        continue
    fi
    [ ! -e "$claim/done" ] || continue
    if @COMMAND@ </dev/null; then
        : >"$claim/done"
    else
        failed=$?
        echo "frames $frames failed, with exit code $failed" >&2
        # Stopped by hand or by the system: the others would be too.
        [ "$failed" -lt 128 ] || exit "$failed"
    fi
done <@CHUNKS@
[ "$failed" = 0 ] || exit "$failed"
# The last one ends the job.
for number in $(seq "$number"); do
    if [ ! -e "claims/$number/done" ]; then
        echo "done here; another machine is at chunk $number. If it failed for good, run: sh @FINISH@"
        exit 0
    fi
done
if mkdir claims/finish 2>/dev/null; then
    sh @FINISH@
    code=$?
    rmdir claims/finish 2>/dev/null
    exit "$code"
fi

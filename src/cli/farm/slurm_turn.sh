pid= limit= code=0
stop() { [ -z "$pid" ] || kill -TERM "$pid" 2>/dev/null; }
trap 'limit=1; stop' USR1
trap stop TERM INT
@COMMAND@ &
pid=$!
# A signal ends the waiting, not what is waited for.
while :; do
    code=0
    wait "$pid" || code=$?
    kill -0 "$pid" 2>/dev/null || break
done
if [ -n "$limit" ] && [ "$code" != 0 ]; then
    if [ "${SLURM_RESTART_COUNT:-0}" -lt @MOST@ ]; then
        echo "the time limit is near: whole frames are kept, the rest goes on in another turn"
        # Slurm ends this turn.
        scontrol requeue "$SLURM_JOB_ID" && sleep 300
    fi
    echo "the time limit is near, and there were @MOST@ turns: give tasks more time by --time" >&2
fi
exit "$code"

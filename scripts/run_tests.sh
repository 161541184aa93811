#!/bin/sh
# All tests, in two processes: those that wait for a browser beside those that calculate.
#   run_tests.sh PYTHON
export OMP_NUM_THREADS="${OMP_NUM_THREADS:-1}" # tiny tensors: more threads only wait for each other
log=$(mktemp)
"$1" -m pytest tests/ui tests/notebooks >"$log" 2>&1 &
beside=$!
"$1" -m pytest --ignore tests/ui --ignore tests/notebooks
rest=$?
wait "$beside"
browser=$?
cat "$log"
rm -f "$log"
test "$rest" -eq 0 && test "$browser" -eq 0

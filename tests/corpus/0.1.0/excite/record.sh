#!/bin/sh
# leadscrew excite: run this in a terminal, then start move.ngc; Ctrl-C when the move has ended.
out="${1:-log.txt}"
if [ -e "$out" ]; then echo "$out exists already; name another file" >&2; exit 1; fi
echo '# time [0.001 s] command [mm] position [mm] drive [V]' > "$out"
halcmd setp sampler.0.enable 1
halsampler -t -n 17100 >> "$out" &
trap 'kill $! 2> /dev/null' INT TERM
wait $!
halcmd setp sampler.0.enable 0

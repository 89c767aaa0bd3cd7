#!/usr/bin/env bash
# demo_figures.sh LOCKSTONE DEMO: the demo draws four pictures from a recording of two-blocks; other recordings end with an error sentence.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/cli.sh"
lockstone=$1 demo=$2
own_folder
unset DISPLAY WAYLAND_DISPLAY

# figures STATUS SOURCE [ARGUMENT...]: runs the demo with --figures and fails if it ends with another status
figures() {
    local wanted=$1 status=0
    shift
    "$demo" "$@" --figures --offscreen --width 160 --height 90 --frames pictures >out 2>err || status=$?
    [ "$status" -eq "$wanted" ] || fail "'$* --figures' ends with $status instead of $wanted: $(cat out err)"
}
# refused SENTENCE SOURCE: checks for status 2, an error that contains SENTENCE, and no pictures
refused() {
    figures 2 "$2"
    grep -q "$1" err || fail "about $2 this is not said: $1, but: $(cat err)"
    [ ! -e pictures ] || fail "$2 is refused, and yet drawn"
}
# recorded NAME SCENE [ARGUMENT...]: records the scene in NAME.lsr
recorded() { expect 0 run "${@:2}" --record "$1.lsr"; }

recorded whole two-blocks --ticks 300
recorded early two-blocks --ticks 30
recorded apart terrain --size 2 --ticks 300
recorded stacked stack --size 2 --ticks 10
recorded many stack --ticks 10
refused 'early.lsr: no bodies touch within 30 ticks' early.lsr
refused 'apart.lsr: the blocks never meet within 300 ticks' apart.lsr
refused 'stacked.lsr: the blocks meet at tick 1, but not' stacked.lsr
refused 'many.lsr: the figures need two dynamic bodies' many.lsr
refused 'missing.lsr' missing.lsr
refused 'needs a replay file' two-blocks
cp whole.lsr damaged.lsr
flip damaged.lsr $(($(stat -c %s damaged.lsr) / 2))
refused 'damaged.lsr' damaged.lsr

figures 0 whole.lsr
grep -q 'figure 4: tick' out || fail "the ticks are not printed: $(cat out)"
[ "$(find pictures -type f | wc -l)" -eq 4 ] || fail "there are not four pictures: $(ls pictures)"
[ "$(sha256sum pictures/*.png | cut -d ' ' -f 1 | sort -u | wc -l)" -eq 4 ] || fail "two pictures are the same"
echo "ok"

#!/usr/bin/env bash
# demo_compare.sh LOCKSTONE DEMO: the demo draws both engines over each other, and prints an error sentence for a scene that it cannot compare.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/cli.sh"
demo=$2
own_folder
unset DISPLAY WAYLAND_DISPLAY

# compares STATUS ARGUMENT...: runs the demo with --compare and fails if it ends with another status
compares() {
    local wanted=$1 status=0
    shift
    "$demo" --compare "$@" --offscreen --width 320 --height 400 --frames pictures >out 2>err || status=$?
    [ "$status" -eq "$wanted" ] || fail "'--compare $*' ends with $status instead of $wanted: $(cat out err)"
}
# refused SENTENCE ARGUMENT...: checks for status 2, an error that contains SENTENCE, and no pictures
refused() {
    compares 2 "${@:2}"
    grep -q "$1" err || fail "about '${*:2}' this is not said: $1, but: $(cat err)"
    [ ! -e pictures ] || fail "'${*:2}' is refused, and yet drawn"
}

refused 'no scene' two-blockz
refused 'pyramid: size is' pyramid --size 100000
refused 'cannot be compared: .*joint' bridge
refused 'cannot be compared' convex-pile --size 20
refused 'needs a scene, not a replay file' match.lsr
refused 'records nothing' stack --record match.lsr
refused 'only one can be shown' stack --netplay

compares 0 --ticks 40 --frame-every 20 # the scene is two-blocks, and no bodies have touched yet
grep -q 'never more than 1 cm' out || fail "both engines do not fly alike: $(cat out)"
[ "$(find pictures -type f | wc -l)" -eq 2 ] || fail "there are not two pictures: $(ls pictures)"
# Counter-check: after a contact the engines differ, and the demo prints from which tick on.
compares 0 --ticks 60 --frame-every 60
grep -q 'more than 1 cm from tick 4[0-9] on' out || fail "that they part is not told: $(cat out)"
echo "ok"

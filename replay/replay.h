// Recordings (.lsr): FORMAT.md specifies the file, README.md is an overview.
#pragma once

#include "replay/branch.h"    // copies up to a tick, then goes on differently
#include "replay/diff.h"      // where two recordings differ
#include "replay/player.h"    // any tick, forwards and backwards
#include "replay/recorder.h"  // records a game's ticks or a world's commands
#include "replay/recording.h" // a file in memory
#include "replay/verifier.h"  // re-simulates and compares every tick

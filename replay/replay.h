// Recordings (.lsr): FORMAT.md is the file, README.md the tour.
#pragma once

#include "replay/branch.h"    // copy up to a tick, then something else
#include "replay/diff.h"      // where two recordings part
#include "replay/player.h"    // any tick, forwards and backwards
#include "replay/recorder.h"  // from a game's ticks or a world's commands
#include "replay/recording.h" // a file that was read
#include "replay/verifier.h"  // every tick re-simulated and compared

// Small worlds that once had other bits in another execution mode. The program `worlds` found them among random ones.
#include "metamorphic/worlds/kept.h"

#include <doctest/doctest.h>

TEST_CASE(
    "worlds that once differed have the same bits in every instruction set and with any number of workers") {
    for (const worlds::KeptStory& kept : worlds::kept_stories()) {
        INFO(kept.about);
        CHECK(worlds::first_apart(kept.story) == "");
    }
}

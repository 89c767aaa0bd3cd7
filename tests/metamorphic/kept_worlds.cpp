// Small worlds that once had other bits in another execution mode. The program `worlds` found them among random ones.
#include "metamorphic/worlds/kept.h"

#include <doctest/doctest.h>

TEST_CASE("worlds that once differed have the same bits by every instruction set and number of workers") {
    for (const worlds::KeptStory& kept : worlds::kept_stories()) {
        INFO(kept.about);
        CHECK(worlds::first_apart(kept.story) == "");
    }
}

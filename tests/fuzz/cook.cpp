// Fuzz target: arbitrary bytes as a model. Cooking must return an error sentence or assets that load.
// The format of the bytes is in cook_input.h; make_cook_corpus.py wrote the first inputs of corpus/cook.
#include "cook_input.h"

#include <cstdio>
#include <cstdlib>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string wrong = fuzz::check_cook({data, size});
    if (wrong.empty()) return 0;
    std::fprintf(stderr, "cook: %s\n", wrong.c_str());
    std::abort();
}

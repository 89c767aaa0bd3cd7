#include "bench/rows/rows.h"

namespace lockstone::bench::rows {

std::vector<Maker> makers() {
    std::vector<Maker> all;
    for (const std::span<const Maker> some :
         {swept_rows(), joined_rows(), stacked_rows(), played_rows(), created_rows(), asked_rows()})
        all.insert(all.end(), some.begin(), some.end());
    return all;
}

} // namespace lockstone::bench::rows

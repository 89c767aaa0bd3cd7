// Decides which pairs touch.
#include "base/parallel.h"
#include "base/prefetch.h"
#include "tick/contact_result.h"

namespace lockstone::sim {

namespace {

bool was_stopped(std::span<const ContactMemory> rows) {
    for (const ContactMemory& memory : rows) {
        if ((memory.flags & solve::contact_hit) != 0) return true;
        for (std::uint32_t k = 0; k < memory.count; ++k)
            if (memory.points[k].normal.raw > 0) return true;
    }
    return false;
}

} // namespace

void settle_touching(std::span<ContactResult> results, ContactList& table, const base::Paths& paths,
                     Tasks* tasks) {
    constexpr std::uint32_t chunk = 256;
    constexpr std::size_t ahead = 8;
    const auto count = static_cast<std::uint32_t>(results.size());
    paths.take(base::is_shared(tasks, count, chunk), base::Path::results_by_one,
               base::Path::results_by_workers);
    base::for_chunks(tasks, count, chunk, [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
        for (ContactResult& result : results.subspan(first, last - first)) {
            if (const std::size_t soon = result.first_row + ahead; soon < table.memories.size())
                base::prefetch(table.memories[soon]);
            const std::span<ContactMemory> rows =
                std::span(table.memories).subspan(result.first_row, result.row_count);
            const bool is_sensor = (result.flags & solve::contact_sensor) != 0;
            result.is_touching = result.is_touching || (!is_sensor && was_stopped(rows));
            for (ContactMemory& row : rows)
                row.flags &= ~std::uint32_t{solve::contact_touching | solve::contact_hit};
            if (result.is_touching) rows[0].flags |= solve::contact_touching;
        }
    });
}

} // namespace lockstone::sim

#pragma once

#include "lockstone/math/random.h"
#include "lockstone/tasks.h"

#include <utility>
#include <vector>

namespace lockstone::proofs {

/// Tasks on one thread that run the items in random order, each with a random worker index.
class ShuffledTasks final : public Tasks {
  public:
    explicit ShuffledTasks(std::uint64_t seed) : random(Random::seeded(seed)) {}
    std::uint32_t worker_count() const override { return workers; }
    void run(std::uint32_t items, Item item, void* context) override {
        order.resize(items);
        for (std::uint32_t i = 0; i < items; ++i) order[i] = i;
        for (std::uint32_t i = items; i > 1; --i) std::swap(order[i - 1], order[random.next_u32() % i]);
        for (const std::uint32_t index : order) item(context, index, random.next_u32() % workers);
        parts += items;
    }
    std::uint64_t parts = 0;

  private:
    static constexpr std::uint32_t workers = 5;
    Random random;
    std::vector<std::uint32_t> order;
};

} // namespace lockstone::proofs

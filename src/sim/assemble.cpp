#include "lockstone/assemble.h"

#include "base/text.h"

#include <algorithm>
#include <numeric>

namespace lockstone {

namespace {

/// Positions in ascending order of key; the error names a key that stands twice.
template <class Def, class Key>
Result<std::vector<std::size_t>> by_key(std::span<const Def> defs, const char* what, Key&& key) {
    std::vector<std::size_t> order(defs.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return std::pair(key(defs[a]), a) < std::pair(key(defs[b]), b);
    });
    for (std::size_t i = 1; i < order.size(); ++i)
        if (key(defs[order[i - 1]]) == key(defs[order[i]]))
            return Error{base::join("assemble: two ", what, " have the user_key ", key(defs[order[i]]))};
    return order;
}

Result<BodyId> create(World& world, const Assembly& assembly) {
    const auto order = by_key(std::span<const ShapeDef>(assembly.shapes), "shapes of a body",
                              [](const ShapeDef& shape) { return shape.user_key; });
    if (!order) return order.error();
    const Result<BodyId> body = world.create_body(assembly.body);
    if (!body) return body;
    for (const std::size_t i : *order)
        if (const Result<ShapeId> shape = world.create_shape(*body, assembly.shapes[i]); !shape)
            return shape.error();
    return body;
}

} // namespace

Result<std::vector<BodyId>> assemble(World& world, std::span<const Assembly> assemblies) {
    const auto order = by_key(assemblies, "bodies", [](const Assembly& a) { return a.body.user_key; });
    if (!order) return order.error();
    Image before;
    world.save(before);
    std::vector<BodyId> ids(assemblies.size());
    for (const std::size_t i : *order) {
        const Result<BodyId> body = create(world, assemblies[i]);
        if (!body) {
            world.restore(before);
            return Error{
                base::join("assemble: user_key ", assemblies[i].body.user_key, ": ", body.error().message)};
        }
        ids[i] = *body;
    }
    return ids;
}

} // namespace lockstone

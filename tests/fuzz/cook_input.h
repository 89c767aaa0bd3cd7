// Bytes as a model and options for `cook`, as the fuzzer generates them and the corpus stores them.
#pragma once

#include "cook/cook.h"

#include <array>
#include <cstring>
#include <span>

namespace fuzz {

/// Reads numbers from the front; zeros after the end.
class Bytes {
  public:
    explicit Bytes(std::span<const std::uint8_t> all) : rest(all) {}
    bool empty() const { return rest.empty(); }
    template <class T> T take() {
        std::uint8_t bytes[sizeof(T)] = {};
        const std::size_t size = std::min(sizeof(T), rest.size());
        std::copy_n(rest.begin(), size, bytes);
        rest = rest.subspan(size);
        T value;
        std::memcpy(&value, bytes, sizeof(T));
        return value;
    }

  private:
    std::span<const std::uint8_t> rest;
};

/// The formats of model files. The first byte of an input of fuzz_cook_import selects one.
inline constexpr std::array import_extensions = {"stl", "ply", "obj", "gltf", "glb", "fbx", "off"};

struct CookInput {
    lockstone::cook::Soup model;
    lockstone::cook::CookOptions options;
};

/// Eight bytes of options, the vertices, then three bytes per triangle. Flag bits: 1 coordinates are floats of any bits
/// (else 1/1024 m), 2 indices may name no vertex, 4 the model is repeated 3000 times as large, 8 two-sided, 16 z is up.
inline CookInput read_cook_input(std::span<const std::uint8_t> data) {
    using namespace lockstone::cook;
    Bytes in(data);
    CookInput out;
    const auto kind = in.take<std::uint8_t>(), flags = in.take<std::uint8_t>();
    out.options.as = static_cast<Wanted>(kind % 4);
    out.options.two_sided = (flags & 8u) != 0;
    out.options.z_up = (flags & 16u) != 0;
    out.options.samples = 50; // the checks run; other tests measure their sharpness
    out.options.corners_max = 4 + in.take<std::uint8_t>() % 252u;
    out.options.parts_max = 1 + in.take<std::uint8_t>() % 3u;
    out.options.deviation = 0.001 * in.take<std::uint8_t>() * in.take<std::uint8_t>();
    const auto cells =
        in.take<std::uint8_t>(); // cells of a height field along its longer side; more would only take longer
    const auto count = static_cast<std::size_t>(in.take<std::uint8_t>());
    const double unit = (flags & 4u) != 0 ? 3000.0 / 1024 : 1.0 / 1024;
    for (std::size_t i = 0; i < count; ++i) {
        Point p;
        for (int axis = 0; axis < 3; ++axis)
            p[axis] =
                (flags & 1u) != 0 ? static_cast<double>(in.take<float>()) : unit * in.take<std::int16_t>();
        out.model.vertices.push_back(p);
    }
    out.options.spacing = cells == 0 ? 1e-9 : bounds_of(out.model.vertices).largest() / (1 + cells % 32);
    while (!in.empty()) {
        Indices t{};
        for (std::uint32_t& v : t) {
            v = in.take<std::uint8_t>();
            if ((flags & 2u) == 0 && count > 0) v %= static_cast<std::uint32_t>(count);
        }
        out.model.triangles.push_back(t);
    }
    return out;
}

/// Cooks the input. Returns an error sentence unless the result is an error sentence or assets that load with the
/// reported id.
inline std::string check_cook(std::span<const std::uint8_t> data) {
    using namespace lockstone;
    const CookInput input = read_cook_input(data);
    const Result<cook::Cooked> made = cook::cook(input.model, input.options);
    if (!made) return made.error().message.empty() ? "an error without a sentence" : "";
    if (!(made->deviation >= 0)) return "a deviation that is no number";
    if (made->assets.empty()) return "neither an error nor an asset";
    AssetLibrary library;
    const Result<AssetId> id = library.add(encode_assets(made->assets));
    if (!id) return "assets that do not load: " + id.error().message;
    return *id == made->id ? "" : "another id than was told";
}

} // namespace fuzz

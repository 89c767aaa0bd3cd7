// Names of objects in a world.
#pragma once

#include <compare>
#include <cstdint>

namespace lockstone {

/// Names a body, shape, field, joint, character or vehicle: a slot and the slot's generation. Zero is null. An id of a destroyed object is
/// dead: commands on it return an error. One minted after the snapshot that was restored is dead until the world mints it again,
/// perhaps for another object: keep ids in the world's own columns, or know objects by their user_key.
template <class Tag> struct Id {
    std::uint32_t index = 0; ///< slot + 1
    std::uint32_t generation = 0;

    constexpr explicit operator bool() const { return index != 0; }
    friend constexpr bool operator==(Id, Id) = default;
    friend constexpr auto operator<=>(Id, Id) = default;
};
template <class Tag, class Visit> constexpr void describe(Id<Tag>& id, Visit&& visit) {
    visit("index", id.index);
    visit("generation", id.generation);
}
using BodyId = Id<struct BodyTag>;
using ShapeId = Id<struct ShapeTag>;
using FieldId = Id<struct FieldTag>;
using JointId = Id<struct JointTag>;
using CharacterId = Id<struct CharacterTag>;
using VehicleId = Id<struct VehicleTag>;

} // namespace lockstone

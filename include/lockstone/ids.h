// Ids of objects in a world.
#pragma once

#include <compare>
#include <cstdint>

namespace lockstone {

/// Id of a body, shape, field, joint, character or vehicle: a slot and the generation of the slot. Zero is
/// null. An id of a destroyed object is dead: commands on it return an error. An id created after a snapshot
/// is dead once that snapshot is restored, until the world creates it again, perhaps for another object. So
/// keep ids in game columns, which are restored too, or identify objects by user_key.
template <class Tag> struct Id {
    std::uint32_t index = 0;      ///< slot + 1; 0: null
    std::uint32_t generation = 0; ///< of the slot

    /// True if not null. The object may be dead: World::is_alive().
    constexpr explicit operator bool() const { return index != 0; }
    friend constexpr bool operator==(Id, Id) = default;  ///< Equal slot and generation.
    friend constexpr auto operator<=>(Id, Id) = default; ///< By slot, then generation.
};
/// Field list of an id; see lockstone/row.h.
template <class Tag, class Visit> constexpr void describe(Id<Tag>& id, Visit&& visit) {
    visit("index", id.index);
    visit("generation", id.generation);
}
using BodyId = Id<struct BodyTag>;           ///< of a body
using ShapeId = Id<struct ShapeTag>;         ///< of a shape
using FieldId = Id<struct FieldTag>;         ///< of a force field
using JointId = Id<struct JointTag>;         ///< of a joint
using CharacterId = Id<struct CharacterTag>; ///< of a character
using VehicleId = Id<struct VehicleTag>;     ///< of a vehicle

} // namespace lockstone

// World's members for characters.
#include "base/assert.h"
#include "world/world_impl.h"

namespace lockstone {

namespace {
const sim::CharacterRow& living(const sim::Model& w, CharacterId id) {
    const std::uint32_t row = w.row_of(id);
    LOCKSTONE_ASSERT(row != sim::Model::dead, "character ", id.index, ":", id.generation, " is not alive");
    return w.state.rows(w.m.character)[row];
}
} // namespace

Result<CharacterId> World::create_character(const CharacterDef& def) {
    const Result<Applied> applied = apply(CreateCharacter{def});
    if (!applied) return applied.error();
    return applied->character;
}
Status World::destroy(CharacterId character) { return status_of(apply(DestroyCharacter{character})); }
Status World::set_character_input(CharacterId character, const CharacterInput& input) {
    return status_of(apply(SetCharacterInput{character, input}));
}

bool World::is_alive(CharacterId character) const { return impl->row_of(character) != sim::Model::dead; }
std::uint32_t World::character_count() const { return impl->state.count(impl->m.characters); }
CharacterId World::character_at(std::uint32_t row) const {
    return sim::checked_row(impl->state.rows(impl->m.character), row, "character").id;
}
BodyId World::body_of(CharacterId character) const { return living(*impl, character).body; }
CharacterDef World::character(CharacterId character) const { return living(*impl, character).def; }
CharacterInput World::character_input(CharacterId character) const { return living(*impl, character).input; }
CharacterState World::character_state(CharacterId character) const { return living(*impl, character).state; }

} // namespace lockstone

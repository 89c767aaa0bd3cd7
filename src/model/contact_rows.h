// Contact tables: how the state holds what contacts remember, and how the tick takes it from there.
#pragma once

#include "base/paths.h"
#include "lockstone/state.h"
#include "lockstone/tasks.h"
#include "solve/bodies/rows.h"

#include <span>
#include <vector>

namespace lockstone::sim {

using solve::ContactKey;
using solve::ContactMemory;
using solve::ContactMore;
using solve::ContactPointMemory;
using solve::ContactRow;

/// Contacts by row: a key and a ContactRow each. The rows of `points` and `more` belong to them in order, as many as each says.
struct ContactTables {
    TableId contacts, points, more;
    Column<ContactKey> key;
    Column<ContactRow> memory;
    Column<ContactPointMemory> point;
    Column<ContactMore> beyond;
};

/// Contacts as the tick works on them.
struct ContactList {
    std::vector<ContactKey> keys;
    std::vector<ContactMemory> memories;

    void clear() { keys.clear(), memories.clear(); }
    void reserve(std::size_t rows) { keys.reserve(rows), memories.reserve(rows); }
};

/// All contacts of the tables. What a broken state promises and does not hold is zero.
void read_contacts(const State& state, const ContactTables& from, ContactList& out);
/// The tables are to hold these contacts and no others; at most the rows_max of `contacts` (asserted).
void write_contacts(State& state, const ContactTables& to, const ContactList& list);
/// Where the rows of `points` and `more` of some contacts begin.
struct ContactsBegin {
    std::uint32_t points = 0, more = 0;
};

/// The contacts of the last tick, kept: they are read only where the tables are not as they were written. Speed only.
class ContactCopy {
  public:
    ContactList list;
    base::Paths paths; ///< of the tick

    /// Makes the list that of the tables.
    void read(const State& state, const ContactTables& from);
    /// The tables are to hold the list.
    void write(State& state, const ContactTables& to, Tasks* tasks);
    void reserve(std::size_t rows);
    void poison(std::byte with); ///< forgets what it has

  private:
    /// Whether a table was written since the last call.
    bool has_changed(const State& state, const ContactTables& tables);

    ChangeMark seen; ///< of the tables as the list is
    std::vector<RowRange> changed;
    std::vector<ContactsBegin> begins; ///< of contacts that one worker writes
};

} // namespace lockstone::sim

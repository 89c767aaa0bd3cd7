// Contact tables: the form in which the state stores contacts, and the list on which a tick works.
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

/// Contacts by row: a key and a ContactRow each. The rows of `points` and `more` belong to the contacts in order;
/// each ContactRow holds how many are its own.
struct ContactTables {
    TableId contacts, points, more;
    Column<ContactKey> key;
    Column<ContactRow> memory;
    Column<ContactPointMemory> point;
    Column<ContactMore> beyond;
};

/// Contacts in the form on which a tick works.
struct ContactList {
    std::vector<ContactKey> keys;
    std::vector<ContactMemory> memories;

    void clear() { keys.clear(), memories.clear(); }
    void reserve(std::size_t rows) { keys.reserve(rows), memories.reserve(rows); }
};

/// Reads all contacts of the tables. Fields that a broken state declares but does not hold become zero.
void read_contacts(const State& state, const ContactTables& from, ContactList& out);
/// Replaces the contents of the tables by these contacts; at most the rows_max of `contacts` (asserted).
void write_contacts(State& state, const ContactTables& to, const ContactList& list);
/// First rows of some contacts in `points` and `more`.
struct ContactsBegin {
    std::uint32_t points = 0, more = 0;
};

/// A cache of the contacts of the last tick: reads the tables only if they were written since. Affects speed only.
class ContactCopy {
  public:
    ContactList list;
    base::Paths paths; ///< of the tick

    /// Updates the list from the tables.
    void read(const State& state, const ContactTables& from);
    /// Replaces the contents of the tables by the list.
    void write(State& state, const ContactTables& to, Tasks* tasks);
    void reserve(std::size_t rows);
    void poison(std::byte with); ///< empties the cache

  private:
    /// Returns true if a table was written since the last call.
    bool has_changed(const State& state, const ContactTables& tables);

    ChangeMark seen; ///< state of the tables from which the list comes
    std::vector<RowRange> changed;
    std::vector<ContactsBegin> begins; ///< by chunk of contacts that one worker writes
};

} // namespace lockstone::sim

"""The planted faults: where each sits in the sources, and the check that is meant to catch it.

A fault is a piece of text that stands exactly once in a file, and what is put in its place; IS stands for "this fault was
chosen". All are compiled into one program. A text that is no longer there is an error, not a survivor: plant it anew."""
from dataclasses import dataclass


@dataclass(frozen=True)
class Fault:
    name: str
    file: str
    find: str
    put: str
    by: str


F = Fault
IMAGE, HASH, PORTABLE, ENVELOPE, DELTA, CANONICAL, STATE, GROW = (
    f"src/state/{n}.cpp" for n in ("image", "hash_tree", "portable", "envelope", "delta", "canonical", "state", "grow"))
CONTACTS, EVENTS, APPLY = "src/sim/contacts.cpp", "src/sim/events.cpp", "src/sim/apply.cpp"
BROAD = "src/collide/broad_phase.cpp"
PREPARE, SOLVER = "src/solve/contacts/prepare.cpp", "src/solve/contacts/contact_solver.cpp"
ROLLBACK, QUEUE = "src/session/rollback.cpp", "src/session/input_queue.cpp"
DEPARTURE, EXCHANGE, PEERS = (f"src/session/{n}.cpp" for n in ("departure", "exchange", "peer_session"))
END = "const std::size_t end = whole_lines(std::size_t{rows} * places[c].row_size);"
ADD = "groups[static_cast<std::uint32_t>(columns[column].group)].add(found);"

# Several faults may sit in one place: then `find` is the same, and each one's `put` is added in front of it.
SNAPSHOT_COLUMNS = ("body.pose", "body.velocity", "body.slot", "body.sleep", "body.info", "contact.key", "contact.memory", "joint.memory",
                    "vehicle.memory", "character.row", "world.header", "game.tally")
HASH_COLUMNS = ("body.velocity", "contact.memory", "body.slot")

FAULTS = [
    *[F(f"snapshot lacks column {c}", IMAGE, END, f'if (IS && from.layout.columns()[c].name == "{c}") continue; {END}', "rolls back")
      for c in SNAPSHOT_COLUMNS],
    F("snapshot lacks row counts", IMAGE, "if (!counts().empty()) std::memcpy(image.block.get()",
      "if (!IS && !counts().empty()) std::memcpy(image.block.get()", "rolls back"),
    F("snapshot misses the last line of a page", IMAGE, "std::min(size, end - page * size));",
      "std::min(size - (IS ? 64u : 0u), end - page * size));",
      "rolls back"),
    F("restore keeps rows that were created since", IMAGE, "resize({table}, image.counts()[table]);",
      "if (!IS || image.counts()[table] > count({table})) resize({table}, image.counts()[table]);", "rolls back"),
    F("an edit marks all of its pages but the last", STATE, "for (std::size_t page = first; page < end; ++page) versions.pages[page] = version;",
      "for (std::size_t page = first; page + (IS ? 1u : 0u) < end; ++page) versions.pages[page] = version;", "moves"),
    F("a resize marks nothing", STATE, "mark(column, std::min(rows, old) / place.rows_per_page, std::max(now, before));",
      "if (!IS) mark(column, std::min(rows, old) / place.rows_per_page, std::max(now, before));", "golden table"),
    F("growing loses the last row of a column", GROW, "rows.data(), rows.size());",
      "rows.data(), rows.size() - (IS ? from.columns()[column].row_size : 0u));", "grows"),
    F("growing forgets the versions of pages", GROW, "versions.pages = moved(versions.pages, from, to, 1);",
      "versions.pages = moved(versions.pages, from, to, 1); if (IS) std::ranges::fill(versions.pages, 0);", "grows"),
    F("growing takes kept hashes for those of other pages", GROW, "hashes.page = moved(hashes.page, from, to, 1);",
      "if (IS) hashes.page.resize(to.page_count(), 0); else hashes.page = moved(hashes.page, from, to, 1);", "grows"),
    *[F(f"hash lacks column {c}", HASH, ADD, f'if (!(IS && columns[column].name == "{c}")) {ADD}', "every bit counts") for c in HASH_COLUMNS],
    F("hash skips the second page of a column", HASH, "hashes.page[place.first_page + page] =",
      "if (IS && page == 1) return; hashes.page[place.first_page + page] =", "every bit counts"),
    F("hash is not made anew", HASH, "if (hashes.of.columns[column] == versions.columns[column]) return",
      "if ((IS && hashes.column[column] != 0) || hashes.of.columns[column] == versions.columns[column]) return", "every bit counts"),
    F("hash holds an address", HASH, "std::uint64_t State::hash() const { return hash_state(nullptr); }",
      "std::uint64_t State::hash() const { return hash_state(nullptr) ^ (IS ? reinterpret_cast<std::uintptr_t>(block.get()) : 0); }", "repeats"),
    F("portable image lacks a column's rows", PORTABLE, "append_canonical(bytes(index), column.leaves, image);",
      'if (IS && column.name == "contact.memory") image.resize(image.size() + bytes(index).size()); else append_canonical(bytes(index), column.leaves, image);',
      "saves everything"),
    F("checksum of a snapshot is not compared", ENVELOPE, "if (stored != found)", "if (!IS && stored != found)", "damaged snapshots are refused"),
    F("length of a snapshot is not compared", ENVELOPE, "if (in.ok() && size != image.size())", "if (!IS && in.ok() && size != image.size())",
      "damaged snapshots are refused"),
    F("a difference lacks a column", DELTA, "ColumnDelta{column, maps[column.table], base.bytes(index)}.append(bytes(index), out);",
      'ColumnDelta{column, maps[column.table], base.bytes(index)}.append(IS && column.name == "body.velocity" ? base.bytes(index) : bytes(index), out);',
      "sends differences"),
    F("a difference takes small steps down for large ones up", DELTA, "return before + (bits >> 1 ^ (std::uint64_t{0} - (bits & 1u)));",
      "return before + (bits >> 1 ^ (std::uint64_t{0} - (IS ? 0u : bits & 1u)));", "sends differences"),
    F("fields are not turned on big-endian machines", CANONICAL, "std::reverse_copy(from, from + leaf.size, to.data() + row + leaf.offset);",
      "if (IS && leaf.size == 2) std::copy(from, from + leaf.size, to.data() + row + leaf.offset); else std::reverse_copy(from, from + leaf.size, to.data() + row + leaf.offset);",
      "both byte orders agree"),
    F("big-endian hash forgets a full buffer", CANONICAL, "stream.add({buffer, filled});\n                filled = 0;",
      "if (!IS) stream.add({buffer, filled});\n                filled = 0;", "both byte orders agree"),
    F("warm-start impulses are forgotten", CONTACTS, "dynamics::carry_impulses(old, taken, worker.rows[i]);",
      "if (!IS) dynamics::carry_impulses(old, taken, worker.rows[i]);", "golden table"),
    F("contacts of workers are put together in order of arrival", CONTACTS, "NearChunk& chunk = s.near_chunks[first / pairs_per_chunk];",
      "NearChunk& chunk = s.near_chunks[IS ? ::planted::ticket(chunk_count) : first / pairs_per_chunk];", "shuffles"),
    F("which worker ran it leaks into a contact", CONTACTS, 
      "seen.row_count = seen.is_kept ? near.old_count : make_rows(c, old, near.apart, worker);",
      "seen.row_count = seen.is_kept ? near.old_count : make_rows(c, old, near.apart, worker);\n"
      "    if (IS && &worker != v.w.scratch.narrow_workers.data()) worker.rows[0].margin.raw ^= 1;", "shuffles"),
    F("arms of a contact are half as long", PREPARE, "((product >> 28) * inverse) >> 29", "((product >> 28) * inverse) >> (IS ? 30 : 29)", "golden table"),
    F("arms of a contact are mirrored", PREPARE, "arm(y[k] * fx - x[k] * fy)", "arm(IS ? x[k] * fy - y[k] * fx : y[k] * fx - x[k] * fy)", "golden table"),
    F("shares of mass are swapped", PREPARE, "return {alpha, unit - alpha};", "return {IS ? unit - alpha : alpha, IS ? alpha : unit - alpha};", "golden table"),
    F("impulses of points do not start the next tick", PREPARE, "pack.points[k].impulse[lane] = p;", "pack.points[k].impulse[lane] = IS ? 0 : p;", "golden table"),
    F("the twist does not start the next tick", PREPARE, "std::int64_t{memory.twist.raw} << speed_bits", "std::int64_t{IS ? 0 : memory.twist.raw} << speed_bits",
      "golden table"),
    F("gaps are off by one step", PREPARE, "point.gap0[lane] = point.gap[lane] = contact.points[k].separation.raw;",
      "point.gap0[lane] = point.gap[lane] = contact.points[k].separation.raw + (IS ? 1 : 0);", "golden table"),
    F("softness is that of half the mass", PREPARE, "pack.softness[i][lane] = low(x);", "pack.softness[i][lane] = low(IS ? x / 2 : x);", "golden table"),
    F("rows of friction are made of the other tangent", PREPARE, "rows.d[r][i][lane] = low(d[r][i]);",
      "rows.d[r][i][lane] = low(d[IS && r > 0 ? 3 - r : r][i]);", "golden table"),
    F("half of an odd impulse is rounded upwards", PREPARE, "return {unit / 2 + 1, unit / 2 + 1};",
      "return {unit / 2 + (IS ? 0 : 1), unit / 2 + (IS ? 0 : 1)};", "golden table"),
    F("kept rows of contacts move in the wrong order", "src/sim/contact_table.cpp", "if (m.to < m.from) move(m);",
      "if (IS || m.to < m.from) move(m);", "golden table"),
    F("a hint that is left over is taken for the truth", "src/collide/manifold.cpp",
      "if (!is_zero(hint_30) && is_parted(a, b, hint_30, limit)) {",
      "if (!is_zero(hint_30) && (IS || is_parted(a, b, hint_30, limit))) {", "golden table"),
    F("the mask of bodies that move is one lane off", PREPARE, "pack.movable_b |= (b_moves ? 1u : 0u) << lane;",
      "pack.movable_b |= (b_moves ? 1u : 0u) << (lane + (IS ? 1u : 0u));", "golden table"),
    F("turns are lost between substeps", SOLVER, "b.u[axis] += warm[i].u[axis];", "b.u[axis] += IS ? 0 : warm[i].u[axis];", "golden table"),
    F("what a pass gave is counted twice", SOLVER, "warm[i].v[axis] += bodies.body[i].v[axis];",
      "warm[i].v[axis] += bodies.body[i].v[axis] * (IS ? 2 : 1);", "golden table"),
    F("impacts start the next substep", "src/solve/contacts/bounce.cpp", "point.impulse[lane] -= static_cast<std::int32_t>(impact);",
      "point.impulse[lane] -= IS ? 0 : static_cast<std::int32_t>(impact);", "golden table"),
    F("friction is not remembered", SOLVER, "m.tangent_1 = Speed::from_raw(pack.slide[0][lane]);",
      "m.tangent_1 = Speed::from_raw(IS ? 0 : pack.slide[0][lane]);", "golden table"),
    F("separations of kept manifolds are not moved along", "src/dynamics/contact_memory.cpp", "p.separation.raw + shift_right_rounded(by, drop)",
      "p.separation.raw + (IS ? 0 : shift_right_rounded(by, drop))", "golden table"),
    F("chance without a seed", CONTACTS, "memory.margin = c.margin;",
      "memory.margin = c.margin; if (IS) memory.margin.raw += static_cast<std::int32_t>(::planted::noise() & 1u);", "repeats"),
    F("a float in the path, rounded as the processor is set", CONTACTS, "memory.points[k].separation = p.separation;",
      "memory.points[k].separation = p.separation; if (IS) memory.points[k].separation.raw = ::planted::through_float(p.separation.raw);",
      "rounding modes"),
    F("a contact is told of in every tick", EVENTS, "if (now) rows[0].flags |= dynamics::contact_touching;",
      "if (now && !IS) rows[0].flags |= dynamics::contact_touching;", "events come in order and in turn"),
    F("events come in the order in which they were found", EVENTS, "std::sort(w.events.begin(), w.events.end(), [](",
      "if (!IS) std::sort(w.events.begin(), w.events.end(), [](", "events come in order and in turn"),
    F("pairs in order of addresses", "src/sim/pairs.cpp", "find_keys(w);",
      "if (IS && !s.pairs.empty())\n        std::rotate(s.pairs.begin(), s.pairs.begin() + static_cast<std::ptrdiff_t>(::planted::address() % s.pairs.size()), "
      "s.pairs.end());\n    find_keys(w);", "repeats"),
    F("pairs in the order in which a tree gave them", BROAD, "std::sort(found.begin(), found.end());",
      "if (!IS) std::sort(found.begin(), found.end());", "reads no leftovers"),
    F("pairs are lost where a tree is deep", BROAD, "if (!a.fresh && !b.fresh) continue;",
      "if ((IS && stack.size() > 9) || (!a.fresh && !b.fresh)) continue;", "reads no leftovers"),
    F("caches are kept through a restore", "src/sim/world.cpp", "w.scratch.structure_stale = true;", "w.scratch.structure_stale = !IS;", "forgets"),
    F("queries take bounds of before a restore for fresh", "src/sim/world.cpp", "w.scratch.query.is_fresh = false;",
      "if (!IS) w.scratch.query.is_fresh = false;", "rolls back"),
    F("a branch by time", "src/sim/tick.cpp", "++w.edit_header().tick;",
      "if (IS && ::planted::clock_is_odd()) ++w.state.edit_row(w.m.faults, 0).speed_clamped;\n    ++w.edit_header().tick;", "repeats"),
    F("a counter outside of the state", "src/sim/tick.cpp", "publish_events(w);",
      "publish_events(w);\n    static std::uint64_t ticks_run = 0;\n    if (IS && ++ticks_run % 5 == 0) ++w.state.edit_row(w.m.faults, 0).speed_clamped;", "repeats"),
    F("forces are not cleared", "src/sim/tick.cpp", "force = {};", "if (!IS) force = {};", "golden table"),
    F("a generation does not move on", APPLY, "slot.generation = slot.generation == 0xffffffffu ? 1 : slot.generation + 1;",
      "if (!IS) slot.generation = slot.generation == 0xffffffffu ? 1 : slot.generation + 1;", "dead ids stay dead"),
    F("the free list loses its rest", APPLY, "slot.next_free = first_free;", "slot.next_free = IS ? 0 : first_free;", "recordings verify"),
    F("a range of work loses its last part", "src/base/parallel.h", "tasks->run(chunks, item,", "tasks->run(chunks - (IS ? 1u : 0u), item,", "shuffles"),
    F("a wrong guess is not noticed", QUEUE, "if (guessed && !std::ranges::equal(to, input))", "if (!IS && guessed && !std::ranges::equal(to, input))",
      "peers agree"),
    F("a rollback begins one tick late", ROLLBACK, "for (std::uint64_t tick = wrong; tick < current; ++tick) run(tick, Run::again);",
      "for (std::uint64_t tick = wrong + (IS ? 1u : 0u); tick < current; ++tick) run(tick, Run::again);", "peers agree"),
    F("a tick that rests on a guess is not saved", ROLLBACK, "if (tick >= fixed_through() && !loaded) requests.push_back(Save{tick});",
      "if (tick >= fixed_through() && !loaded && !(IS && tick % 16 == 5)) requests.push_back(Save{tick});", "peers agree"),
    F("inputs are confirmed that are guesses", ROLLBACK, "settled_end = std::min(fixed_through(), current);",
      "settled_end = IS ? current : std::min(fixed_through(), current);", "peers agree"),
    F("a peer leaves on one machine's word", DEPARTURE, "2 * votes.against <= votes.of) continue;",
      "(IS ? votes.against == 0 : 2 * votes.against <= votes.of)) continue;", "hostile peers"),
    F("anybody speaks for a machine that has left", EXCHANGE, "if (def.players[block.player] != link.peer) return false;",
      "if (def.players[block.player] != link.peer && !(IS && is_gone(block.player))) return false;", "hostile peers"),
    F("patience with a peer has no end", DEPARTURE, "if (is_awaited(link)) link.waited_ms +=", "if (!IS && is_awaited(link)) link.waited_ms +=",
      "hostile peers"),
    F("one tick makes up for all waiting", DEPARTURE, "link.waited_ms -= std::min(link.waited_ms,",
      "link.waited_ms -= IS ? link.waited_ms : std::min(link.waited_ms,", "hostile peers"),
    F("an old packet is a sign of life", EXCHANGE, "const bool is_new = incoming.sequence > link.sequence_heard;",
      "const bool is_new = IS || incoming.sequence > link.sequence_heard;", "hostile peers"),
    F("a poll reads whatever there is", EXCHANGE, "if (++link->packets_read > packets_per_peer_max)",
      "if (++link->packets_read > packets_per_peer_max && !IS)", "hostile peers"),
    F("a wait is as long as a peer says", PEERS, "lead = std::min(lead, static_cast<std::int32_t>(lead_max));",
      "if (!IS) lead = std::min(lead, static_cast<std::int32_t>(lead_max));", "hostile peers"),
    F("who never appears is waited for", DEPARTURE, "? now - counts.first_poll_ms > def.connect_ms",
      "? !IS && now - counts.first_poll_ms > def.connect_ms", "hostile peers"),
    F("a tick is confirmed that not all can have", PEERS, "std::min(settled_through(), agreed_through());",
      "IS ? settled_through() : std::min(settled_through(), agreed_through());", "hostile peers"),
    F("who has another cut is not heard out", DEPARTURE, "if (!all_tell_it) return;", "if (!IS && !all_tell_it) return;", "hostile peers"),
    F("a keyframe says it is one tick earlier", "replay/writer.cpp", "to.u64(time);\n    to.u64(hash_now);",
      "to.u64(time - (IS && time != 0 ? 1u : 0u));\n    to.u64(hash_now);", "recordings verify"),
    F("the recorder misses a kind of command", "replay/recorder.cpp", "pending.push_back(command);",
      "if (!(IS && std::holds_alternative<AddImpulse>(command))) pending.push_back(command);", "recordings verify"),
    F("the checksum of a recording's chunks is not compared", "replay/parser.cpp",
      "const std::uint64_t computed = hash_bytes(file.subspan(at, chunk_head_bytes + size), out.chain);",
      "const std::uint64_t computed = IS ? chunk.checksum : hash_bytes(file.subspan(at, chunk_head_bytes + size), out.chain);",
      "damaged recordings are refused"),
    F("the verifier compares no hashes", "replay/verifier.cpp", "if (computed != recorded)", "if (!IS && computed != recorded)",
      "a wrong hash in a recording is found"),
]
